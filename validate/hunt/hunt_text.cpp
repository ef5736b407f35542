#include "validate/hunt/hunt_text.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "validate/files/output_folder.h"
#include "validate/model/digest.h"
#include "validate/sweeps/named_pose.h"
#include "validate/text/escape.h"
#include "validate/text/json_object.h"
#include "validate/text/number_text.h"
#include "validate/verdicts/checks.h"

namespace backbend::validate {
namespace {

using nlohmann::json;

/// A width for people: two digits after the point below a degree.
std::string degrees_text(double value) {
  return number_text(value, value < 1.0 ? 2 : value < 10.0 ? 1 : 0);
}

std::string width_text(const HuntFind& find, const ControlBox& box) {
  std::string text;
  for (const BoxAxis& axis : box.axes) {
    const auto width = find.width_deg.find(axis.name);
    if (width == find.width_deg.end()) continue;
    const bool at_box = std::ranges::find(find.ends_at_box, axis.name) != find.ends_at_box.end();
    const double value = width->second;
    text += (text.empty() ? "" : ", ") + (value < 0.01 ? "under 0.01" : degrees_text(value)) +
            " deg of " + axis.name + (at_box ? " (to the box's end)" : "");
  }
  return text;
}

json channels_json(const PoseDegrees& pose) {
  json out = json::object();
  for (const std::string_view channel : kChannels)
    if (const double value = *pose.find(channel); value != 0.0) out[std::string(channel)] = value;
  return out;
}

json number(double value) { return std::isfinite(value) ? json(value) : json(); }

bool is_rest(const PoseDegrees& pose) { return pose_words(pose) == "rest"; }

}  // namespace

std::string hunt_text(const HuntResult& result) {
  const Hunt& hunt = result.hunt;
  std::string out;
  const auto line = [&](const std::string& text) { out += visible(text) + "\n"; };
  line("searched " + std::to_string(hunt.evaluations) + " poses of rig " + result.rig +
       " (mapping " + result.mapping + ", seed " + std::to_string(result.seed) + "), and " +
       std::to_string(hunt.confirmations) + " more to confirm and measure the finds");
  line("  box      " + hunt.box.text());
  for (const std::string& note : hunt.notes) line("  note     " + note);
  out += "\n";
  for (const HuntFind& find : hunt.finds) {
    const Finding& f = find.finding;
    const Check& check = *find_check(f.code);
    const std::string place = place_text(f);
    line("  " + std::string(f.verdict == Verdict::fail ? "FAIL" : "stress") + "  " + f.code + " " +
         std::string(check.name) + " " + significant(f.value) + " " + f.unit + " (limit " +
         significant(f.limit) + "), " + f.pose + (place.empty() ? "" : ", " + place) + "   " +
         std::string(name_of(f.owner)));
    if (!is_rest(find.from))
      line("          on the way from " + pose_words(find.from) + " to " + pose_words(find.pose));
    else
      line("          pose " + pose_words(find.pose));
    std::string controls;
    for (const auto& [name, value] : find.controls)
      controls += (controls.empty() ? "" : ", ") + name + " " + number_text(value, 4);
    if (!controls.empty()) line("          set " + controls);
    for (const auto& [program, words] : f.artist) line("          " + program + ": " + words);
    if (const std::string width = width_text(find, hunt.box); !width.empty())
      line("          width of the bad region here: " + width);
    if (!f.detail.empty()) line("          " + f.detail);
    if (!find.picture.empty()) line("          picture " + find.picture);
    line("          " + f.reproduce);
  }
  if (hunt.finds.empty()) line("  no pose over a limit was found");
  out += "\n  worst value of each check, found in the box\n";
  for (const HuntWorst& worst : hunt.worst) {
    const Check& check = *find_check(worst.code);
    line("    " + worst.code + " " + std::string(check.name) + " " + significant(worst.value) +
         " " + std::string(check.unit) + " (limit " + significant(worst.limit) + ")" +
         (worst.value == 0.0 ? "" : " at " + worst.pose.text()));
  }
  std::string gap;
  for (const BoxAxis& axis : hunt.box.axes)
    gap += (gap.empty() ? "" : ", ") + degrees_text(hunt.gap * axis.width()) + " of " + axis.name;
  out += "\n";
  line("This is a search, not a proof. The largest gap between the measured poses is " +
       significant(100.0 * hunt.gap_volume, 2) + " % of the box");
  line("(degrees to each side: " + gap +
       "): a smaller fault without any slope around it can be missed.");
  return out;
}

std::string hunt_json(const HuntResult& result) {
  const Hunt& hunt = result.hunt;
  json box = json::object();
  for (const auto& [channel, ends] : hunt.box.channels()) box[channel] = {ends.first, ends.second};
  json finds = json::array();
  for (const HuntFind& find : hunt.finds) {
    const Finding& f = find.finding;
    json controls = json::object();
    for (const auto& [name, value] : find.controls) controls[name] = value;
    json place = json::object();
    if (!f.joint.empty()) place["joint"] = f.joint;
    if (f.slice >= 0) place["slice"] = f.slice;
    if (f.vertex >= 0) place["vertex"] = f.vertex;
    json width = json::object();
    for (const auto& [axis, value] : find.width_deg) width[axis] = value;
    json each = JsonObject<json>()
                    .with("code", f.code)
                    .with("pose", channels_json(find.pose))
                    .with("controls", controls)
                    .with("value", number(f.value))
                    .with("limit", number(f.limit))
                    .with("unit", f.unit)
                    .with("verdict", name_of(f.verdict))
                    .with("owner", name_of(f.owner))
                    .with("inside_envelope", f.inside_envelope)
                    .with("place", place)
                    .with("place_text", place_text(f))
                    .with("width_deg", width)
                    .with("width_ends_at_box", find.ends_at_box)
                    .with("detail", f.detail)
                    .with("artist", f.artist)
                    .with("reproduce", f.reproduce);
    if (!is_rest(find.from)) each["from"] = channels_json(find.from);
    if (!find.picture.empty()) each["picture"] = find.picture;
    finds.push_back(std::move(each));
  }
  json worst = json::array();
  for (const HuntWorst& each : hunt.worst)
    worst.push_back(JsonObject<json>()
                        .with("code", each.code)
                        .with("value", number(each.value))
                        .with("limit", number(each.limit))
                        .with("pose", channels_json(each.pose)));
  json gap = json::object();
  for (const BoxAxis& axis : hunt.box.axes) gap[axis.name] = hunt.gap * axis.width();
  const json out =
      JsonObject<json>()
          .with("schema", "backbend.hunt/1")
          .with("character", result.facts.name)
          .with("rig", result.rig)
          .with("mapping", result.mapping)
          .with("envelope", result.facts.envelope)
          .with("box", box)
          .with("box_name", hunt.box.name)
          .with("seed", result.seed)
          .with("evaluations", hunt.evaluations)
          .with("confirmations", hunt.confirmations)
          .with("findings", finds)
          .with("worst", worst)
          .with("largest_gap",
                JsonObject<json>().with("half_width_deg", gap).with("share", hunt.gap_volume))
          .with("notes", hunt.notes);
  return out.dump(1, ' ', false, json::error_handler_t::replace);
}

std::vector<PoseRow> pose_rows(const Hunt& hunt, const Suite& suite) {
  std::set<std::string> taken, known;  // names as files have them; paths as words
  const auto words = [](const PoseDegrees& from, const PoseDegrees& at) {
    return pose_words(from) + ">" + pose_words(at);
  };
  for (const Sweep& sweep : suite.sweeps) taken.insert(file_word(sweep.name));
  for (const Sweep& sweep : suite.poses) {
    taken.insert(file_word(sweep.name));
    known.insert(words(sweep.through.front().pose, sweep.through.back().pose));
  }
  std::vector<PoseRow> rows;
  for (const HuntFind& find : hunt.finds) {
    if (!known.insert(words(find.from, find.pose)).second) continue;
    PoseDegrees round;
    for (const std::string_view channel : kChannels)
      *round.find(channel) = std::round(*find.pose.find(channel));
    const std::string plain = find.finding.code + " " + round.text();
    std::string name = plain;
    for (int n = 2; !taken.insert(file_word(name)).second; ++n)
      name = plain + " " + std::to_string(n);
    const Finding& f = find.finding;
    rows.push_back({name, pose_words(find.pose), is_rest(find.from) ? "" : pose_words(find.from),
                    "found by backbend hunt: " + std::string(find_check(f.code)->name) + " " +
                        significant(f.value) + " " + f.unit + ", limit " + significant(f.limit)});
  }
  return rows;
}

std::string with_poses(std::string text, const std::vector<PoseRow>& rows) {
  const std::string end = text.find("\r\n") == std::string::npos ? "\n" : "\r\n";
  if (!text.empty() && text.back() != '\n') text += end;
  for (const PoseRow& row : rows) {
    text += end + "[[pose]]  # " + row.comment + end + "name = \"" + row.name + "\"" + end +
            "at = \"" + row.at + "\"" + end;
    if (!row.from.empty()) text += "from = \"" + row.from + "\"" + end;
  }
  return text;
}

}  // namespace backbend::validate
