#include "validate/evidence/picture_diff.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "render/image/exr.h"
#include "validate/files/output_folder.h"
#include "validate/sweeps/sweep.h"
#include "validate/text/escape.h"
#include "validate/text/json_object.h"
#include "validate/verdicts/checks.h"
#include "validate/verdicts/exit_code.h"

namespace backbend::validate {
namespace {

namespace fs = std::filesystem;

render::Frame read_picture(const fs::path& file) {
  try {
    return render::decode_exr(read_bytes(file));
  } catch (const render::RenderError& error) {
    throw ReadError(file.string() + ": " + error.what());
  }
}

/// Relative names of the pictures below a folder. Links to folders are not followed.
std::set<std::string> pictures_below(const fs::path& folder) {
  std::set<std::string> names;
  std::error_code error;
  for (fs::recursive_directory_iterator it(folder, error), end; !error && it != end;
       it.increment(error)) {
    if (it->path().extension() == ".exr" && it->is_regular_file(error))
      names.insert(it->path().lexically_relative(folder).generic_string());
  }
  if (error) throw ReadError(folder.string() + ": " + error.message());
  return names;
}

FrameDifference compare_files(const fs::path& a, const fs::path& b, const PictureLimits& limits) {
  try {
    return frame_difference(read_picture(a), read_picture(b), limits);
  } catch (const ImageError& error) {
    throw ReadError(a.string() + " and " + b.string() + ": " + error.what());
  }
}

nlohmann::json number_or_null(double value) {
  return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json(nullptr);
}

nlohmann::json to_json(const PicturePairDifference& pair) {
  nlohmann::json out = JsonObject<nlohmann::json>().with("name", valid_utf8(pair.name));
  if (!pair.in_a || !pair.in_b) {
    out["verdict"] = "missing";
    out["missing_in"] = pair.in_a ? "b" : "a";
    return out;
  }
  const FrameDifference& d = pair.difference;
  out["verdict"] = name_of(d.verdict());
  out["identical"] = d.identical;
  for (const auto& [key, names] :
       {std::pair("only_a", &d.only_a), std::pair("only_b", &d.only_b)}) {
    out[key] = nlohmann::json::array();
    for (const std::string& name : *names) out[key].push_back(valid_utf8(name));
  }
  out["measures"] = nlohmann::json::array();
  for (const PictureMeasure& m : d.measures)
    out["measures"].push_back(JsonObject<nlohmann::json>()
                                  .with("name", m.name)
                                  .with("unit", m.unit)
                                  .with("value", number_or_null(m.value))
                                  .with("limit", number_or_null(m.limit))
                                  .with("verdict", name_of(m.verdict)));
  if (d.noise)
    out["noise"] = JsonObject<nlohmann::json>()
                       .with("values", d.noise->values)
                       .with("bound", number_or_null(d.noise->bound))
                       .with("largest", number_or_null(d.noise->largest));
  if (std::isfinite(d.picture.largest) && d.picture.x >= 0)
    out["worst_pixel"] = {d.picture.x, d.picture.y};
  return out;
}

std::string line_of(const PicturePairDifference& pair) {
  const std::string name = visible(pair.name);
  if (!pair.in_a || !pair.in_b)
    return "MISSING  " + name + " is not in " + (pair.in_a ? "B" : "A") + "\n";
  const FrameDifference& d = pair.difference;
  if (d.identical) return "same     " + name + ": every channel, every bit\n";
  const Verdict verdict = d.verdict();
  std::string text = (verdict == Verdict::pass   ? "alike    "
                      : verdict == Verdict::fail ? "DIFFERS  "
                                                 : "UNSURE   ") +
                     name + "\n";
  for (const PictureMeasure& m : d.measures) {
    if (m.verdict == Verdict::not_applicable) continue;
    text += "  " +
            std::string(m.verdict == Verdict::fail           ? "FAIL"
                        : m.verdict == Verdict::not_measured ? "none"
                        : std::isfinite(m.limit)             ? "pass"
                                                             : "    ") +
            "  " + padded(m.name, 24) + number_text(m.value, 5) +
            (m.unit.empty() ? "" : " " + m.unit) +
            (std::isfinite(m.limit) ? "  (limit " + number_text(m.limit, 4) + ")" : "") + "\n";
  }
  for (const auto& [side, names] : {std::pair("A", &d.only_a), std::pair("B", &d.only_b)}) {
    if (names->empty()) continue;
    text += std::string("  only in ") + side + ":";
    for (const std::string& channel : *names) text += " " + visible(channel);
    text += "\n";
  }
  return text;
}

}  // namespace

bool PictureDiff::complete() const {
  return std::ranges::all_of(pairs, [](const auto& pair) { return pair.in_a && pair.in_b; });
}

int PictureDiff::exit_code() const {
  bool differs = false, gap = pairs.empty();
  for (const PicturePairDifference& pair : pairs) {
    if (!pair.in_a || !pair.in_b) continue;
    differs = differs || pair.difference.verdict() == Verdict::fail;
    gap = gap || pair.difference.verdict() == Verdict::not_measured;
  }
  return first_exit_code({complete() ? kExitOk : kExitIncomplete, differs ? kExitFindings : kExitOk,
                          gap ? kExitNotMeasured : kExitOk});
}

PictureDiff diff_pictures(const fs::path& a, const fs::path& b, const PictureLimits& limits,
                          Progress& progress) {
  PictureDiff diff;
  const bool folder_a = fs::is_directory(a), folder_b = fs::is_directory(b);
  if (folder_a != folder_b && fs::exists(a) && fs::exists(b))
    throw ReadError((folder_a ? a : b).string() + " is a folder and " +
                    (folder_a ? b : a).string() + " is not: compare two files or two folders");
  if (!folder_a || !folder_b) {
    diff.pairs.push_back({a.filename().string(), true, true, compare_files(a, b, limits)});
    return diff;
  }
  const std::set<std::string> in_a = pictures_below(a), in_b = pictures_below(b);
  std::set<std::string> all = in_a;
  all.insert(in_b.begin(), in_b.end());
  progress.start("pictures", all.size());
  for (const std::string& name : all) {
    poll_interrupt();
    PicturePairDifference pair{name, in_a.contains(name), in_b.contains(name), {}};
    if (pair.in_a && pair.in_b) pair.difference = compare_files(a / name, b / name, limits);
    pair.difference.picture.map.clear();  // a night has thousands of pictures
    diff.pairs.push_back(std::move(pair));
    progress.step();
  }
  progress.finish();
  return diff;
}

std::string picture_diff_json(const PictureDiff& diff) {
  nlohmann::json pairs = nlohmann::json::array();
  for (const PicturePairDifference& pair : diff.pairs) pairs.push_back(to_json(pair));
  return nlohmann::json(JsonObject<nlohmann::json>()
                            .with("schema", "backbend.diff/1")
                            .with("complete", diff.complete())
                            .with("exit_code", diff.exit_code())
                            .with("pictures", std::move(pairs)))
             .dump(2) +
         "\n";
}

std::string picture_diff_text(const PictureDiff& diff) {
  std::string text;
  std::size_t same = 0, alike = 0, differs = 0, missing = 0;
  for (const PicturePairDifference& pair : diff.pairs) {
    text += line_of(pair);
    if (!pair.in_a || !pair.in_b)
      ++missing;
    else if (pair.difference.identical)
      ++same;
    else if (pair.difference.verdict() == Verdict::pass)
      ++alike;
    else if (pair.difference.verdict() == Verdict::fail)
      ++differs;
  }
  return text + std::to_string(diff.pairs.size()) + " compared: " + std::to_string(same) +
         " the same, " + std::to_string(alike) + " alike within limits, " +
         std::to_string(differs) + " different, " + std::to_string(missing) + " missing\n";
}

}  // namespace backbend::validate
