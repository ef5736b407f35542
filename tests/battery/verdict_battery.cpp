// How often `check` is wrong about other people's characters: clean cases that it fails, and
// planted faults that it misses, misplaces or books to the wrong owner.
//
//   verdict_battery [options]
//
// --cases N     cases of each family [40]
// --seed S      even seeds are for setting limits, odd ones for judging them [1]
// --family F    only `clean rig`, `clean clip`, `weight fault` or `motion fault`
// --shard I/N   only every Nth case, from I = 0 on
// --only N      only case N, with what was found
// --lines FILE  a line of JSON for each case, to be summed with others
// --sum FILE... no cases: the tables of such files
// --keep DIR    the files of every wrong case, with the command that judges them
// --characters DIR   [BACKBEND_CHARACTERS, else beside the project]
// --bodies DIR  the .glb and .fbx files of a folder instead, with a family of rigs
//
// Exit code 0 where no clean case fails and 95 of 100 faults of a plain size are found, 1 where
// not, 77 without characters.
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>

#include "tests/battery/battery_options.h"
#include "tests/battery/cases.h"
#include "tests/battery/judged_case.h"
#include "tests/battery/tables.h"
#include "validate/sweeps/sweep.h"
#include "validate/verdicts/checks.h"

namespace backbend::battery {
namespace {

namespace fs = std::filesystem;
using Index = std::size_t;
using nlohmann::json;
using validate::Finding;
using validate::number_text;

constexpr Family kFamilies[] = {Family::clean_rig, Family::clean_clip, Family::weight_fault,
                                Family::motion_fault};

struct Options : BatteryOptions {
  std::uint64_t cases = 40;
  std::string family, bodies;
  std::optional<std::uint64_t> only;
};

Options read_options(int argc, char** argv) {
  Options out;
  static_cast<BatteryOptions&>(out) = read_battery_options(
      "verdict_battery", argc, argv, [&](const std::string& word, const std::string& value) {
        if (word == "--cases")
          out.cases = number_of(value);
        else if (word == "--family")
          out.family = value;
        else if (word == "--bodies")
          out.bodies = value;
        else if (word == "--only")
          out.only = number_of(value);
        else
          return false;
        return true;
      });
  if (!out.bodies.empty()) {
    if (out.family != name_of(Family::clean_rig) && out.family != name_of(Family::weight_fault))
      out.usage("--bodies needs --family 'clean rig' or 'weight fault'");
    out.characters = out.bodies;
  }
  return out;
}

/// The characters in a folder, by name; none where it is not specified.
std::vector<std::string> bodies_in(const fs::path& folder) {
  std::vector<std::string> out;
  if (folder.empty()) return out;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.path().extension() == ".glb" || entry.path().extension() == ".fbx")
      out.push_back(entry.path().filename());
  if (out.empty()) throw std::runtime_error(folder.string() + ": no .glb and no .fbx file");
  std::sort(out.begin(), out.end());
  return out;
}

void write_bytes(const fs::path& file, const std::vector<std::uint8_t>& bytes) {
  std::ofstream out(file, std::ios::binary);
  out.write(reinterpret_cast<const char*>(bytes.data()),
            static_cast<std::streamsize>(bytes.size()));
  if (!out.flush()) throw std::runtime_error(file.string() + ": cannot be written");
}

/// Files of a case in a folder, and the command that judges them.
struct CaseFiles {
  fs::path character, clip;
  std::string command() const {
    std::string out = "backbend check";
    if (!character.empty()) out += " " + character.string();
    if (!clip.empty()) out += " --baked " + clip.string();
    return out + " --quick";
  }
};

CaseFiles write_case(const fs::path& folder, const std::string& stem, const std::string& character,
                     const std::vector<std::uint8_t>& body, const std::vector<std::uint8_t>& clip,
                     bool clip_is_glb) {
  fs::create_directories(folder);
  CaseFiles out;
  if (!clip_is_glb) {
    out.character = folder / (stem + fs::path(character).stem().string() + ".glb");
    write_bytes(out.character, body);
  }
  if (!clip.empty()) {
    out.clip = folder / (stem + (clip_is_glb ? "animated.glb" : "motion.clip"));
    write_bytes(out.clip, clip);
  }
  return out;
}

Outcome judged(const CaseFiles& files) {
  return files.clip.empty() ? check_character(files.character)
                            : check_clip(files.character, files.clip);
}

bool is_mesh_or_input(const Finding& finding) {
  const validate::Check* check = validate::find_check(finding.code);
  return check != nullptr &&
         (check->subject == validate::Subject::mesh || check->subject == validate::Subject::input);
}

std::string short_text(const Finding& finding) {
  std::string out = finding.code + " " + std::string(validate::name_of(finding.owner)) + " " +
                    number_text(finding.value, 2) + " > " + number_text(finding.limit, 2);
  if (!finding.joint.empty()) out += " " + finding.joint;
  if (finding.slice >= 0) out += " slice " + std::to_string(finding.slice);
  if (finding.vertex >= 0) out += " vertex " + std::to_string(finding.vertex);
  return out + " at " + finding.pose;
}

/// What the verdict got right of a planted fault: by the finding that tells most of it.
struct Score {
  bool found = false, placed = false, sized = false, owned = false;
  bool has_size = false;
  int sum() const { return found + placed + sized + owned; }
};

/// Whether the twin without the fault fails by the same check as badly.
bool is_the_fault(const Finding& finding, const Outcome& twin) {
  const validate::Check* check = validate::find_check(finding.code);
  return check != nullptr &&
         std::none_of(twin.failing.begin(), twin.failing.end(), [&](const Finding& other) {
           return other.code == finding.code &&
                  validate::excess(*check, finding.value, finding.limit) <=
                      1.1 * validate::excess(*check, other.value, other.limit);
         });
}

bool near_touched(const skin::Character& body, const std::vector<bool>& touched, int vertex) {
  const auto v = static_cast<Index>(vertex);
  if (v >= touched.size()) return false;
  if (touched[v]) return true;
  for (const glm::uvec3& t : body.triangles)
    if (t.x == v || t.y == v || t.z == v)
      for (int k = 0; k < 3; ++k)
        if (touched[t[k]]) return true;
  return false;
}

bool is_placed(const Finding& finding, const Case& each) {
  const WeightFault& fault = *each.weight_fault;
  if (fault.joints.contains(finding.joint)) return true;
  if (finding.vertex >= 0 && near_touched(each.faulted, fault.touched, finding.vertex)) return true;
  return fault.joints.contains(finding.between[0]) || fault.joints.contains(finding.between[1]);
}

Score score(const Case& each, const Outcome& outcome, const Outcome& twin) {
  Score best;
  best.has_size = each.motion_fault && each.motion_fault->jump;
  if (outcome.exit_code != 1 && outcome.exit_code != 3) return best;
  if (!outcome.refused.empty()) {  // refused by name: as good as found
    best.found = best.placed = best.owned = twin.refused.empty();
    return best;
  }
  for (const Finding& finding : outcome.failing) {
    if (each.weight_fault && !is_mesh_or_input(finding)) continue;
    if (!is_the_fault(finding, twin)) continue;
    Score now = best;
    now.found = true;
    now.placed = now.sized = now.owned = false;
    if (each.weight_fault) {
      now.placed = is_placed(finding, each);
      now.owned =
          finding.owner == validate::Owner::weights || finding.owner == validate::Owner::input;
    } else {
      const MotionFault& fault = *each.motion_fault;
      now.placed = fault.joints.contains(finding.joint) &&
                   (fault.lasting || std::abs(finding.at.pose - fault.frame) <= 1);
      now.sized = fault.jump && finding.code == "BB001" &&
                  std::abs(finding.value - fault.size) <= 0.05 * fault.size;
      now.owned = finding.owner == validate::Owner::rig || finding.owner == validate::Owner::motion;
    }
    if (now.sum() > best.sum()) best = now;
  }
  return best;
}

class Battery {
 public:
  explicit Battery(Options options)
      : options_(std::move(options)),
        maker_(options_.characters, bodies_in(options_.bodies)),
        scratch_(fs::temp_directory_path() / ("verdict_battery_" + std::to_string(::getpid()))) {
    if (!options_.lines.empty()) lines_.open(options_.lines, std::ios::app);
  }
  ~Battery() {
    std::error_code ignored;
    fs::remove_all(scratch_, ignored);
  }
  Battery(const Battery&) = delete;
  Battery& operator=(const Battery&) = delete;

  bool has_characters() const { return maker_.has_characters(); }

  std::vector<json> run() {
    std::vector<json> out;
    for (const Family family : kFamilies) {
      if (!options_.family.empty() && options_.family != name_of(family)) continue;
      for (std::uint64_t n = options_.shard; n < options_.cases; n += options_.shards) {
        if (options_.only && n != *options_.only) continue;
        json line = judge_one(family, n);
        if (lines_.is_open()) lines_ << line.dump() << std::endl;
        out.push_back(std::move(line));
      }
    }
    return out;
  }

 private:
  json judge_one(Family family, std::uint64_t n) {
    const auto start = std::chrono::steady_clock::now();
    json line = {{"family", name_of(family)}, {"n", n}, {"seed", options_.seed}};
    std::optional<Case> each;
    try {
      each = maker_.make(family, options_.seed, n);
    } catch (const std::exception& error) {
      line["not_made"] = error.what();
    }
    if (!each) {
      if (!line.contains("not_made")) line["not_made"] = "no place for this fault";
      return line;
    }
    const CaseFiles files =
        write_case(scratch_, "", each->character, each->body, each->clip, each->clip_is_glb);
    const Outcome outcome = judged(files);
    line["character"] = each->character;
    line["steps"] = each->steps;
    line["exit"] = outcome.exit_code;
    line["refused"] = outcome.refused;
    line["findings"] = json::array();
    for (const Finding& finding : outcome.failing)
      line["findings"].push_back({{"code", finding.code},
                                  {"owner", validate::name_of(finding.owner)},
                                  {"text", short_text(finding)}});
    for (const auto& [metric, value] : outcome.worst)
      if (std::isfinite(value)) line["worst"][metric] = value;
    bool wrong = outcome.exit_code != 0;
    if (each->weight_fault || each->motion_fault) {
      const Outcome& twin = twin_of(*each);
      if (!twin.refused.empty()) {
        line["not_made"] = "refused without the fault: " + twin.refused;
        return line;
      }
      const Score is = score(*each, outcome, twin);
      line["healthy"] = twin.exit_code == 0;
      line["fault"] = each->weight_fault ? each->weight_fault->kind : each->motion_fault->kind;
      line["unit"] = each->weight_fault ? each->weight_fault->unit : each->motion_fault->unit;
      line["size"] = each->weight_fault ? each->weight_fault->size : each->motion_fault->size;
      line["plain"] = each->weight_fault ? each->weight_fault->plain : each->motion_fault->plain;
      line["joints"] = each->weight_fault ? each->weight_fault->joints : each->motion_fault->joints;
      if (each->motion_fault) line["frame"] = each->motion_fault->frame;
      line["twin_exit"] = twin_of(*each).exit_code;
      line["found"] = is.found;
      line["placed"] = is.placed;
      line["owned"] = is.owned;
      if (is.has_size) line["sized"] = is.sized;
      wrong = !is.found || !is.placed || !is.owned || (is.has_size && !is.sized);
    }
    line["seconds"] =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    if (options_.only) {
      std::printf("%s\n", line.dump(1).c_str());
      for (const std::string& reason : outcome.reasons) std::printf("%s\n", reason.c_str());
    }
    if (wrong && !options_.keep.empty()) {
      const std::string stem = std::string(name_of(family)) + "_" + std::to_string(options_.seed) +
                               "_" + std::to_string(n) + "_";
      std::string safe = stem;
      std::replace(safe.begin(), safe.end(), ' ', '_');
      const CaseFiles kept = write_case(options_.keep, safe, each->character, each->body,
                                        each->clip, each->clip_is_glb);
      line["command"] = kept.command();
    }
    return line;
  }

  const Outcome& twin_of(const Case& each) {
    const auto [entry, is_new] = twins_.try_emplace(each.twin);
    if (is_new)
      entry->second = judged(
          write_case(scratch_ / "twin", "", each.character, each.twin_body, each.twin_clip, false));
    return entry->second;
  }

  Options options_;
  CaseMaker maker_;
  fs::path scratch_;
  std::map<std::string, Outcome> twins_;
  std::ofstream lines_;
};

int main_of(int argc, char** argv) {
  Options options = read_options(argc, argv);
  std::vector<json> lines;
  if (!options.sum.empty()) {
    lines = options.lines_to_sum();
  } else {
    Battery battery(options);
    if (!battery.has_characters()) return skipped_for_want_of_characters();
    lines = battery.run();
  }
  return print_tables(lines) ? 0 : 1;
}

}  // namespace
}  // namespace backbend::battery

int main(int argc, char** argv) {
  try {
    return backbend::battery::main_of(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "verdict_battery: %s\n", error.what());
    return 2;
  }
}
