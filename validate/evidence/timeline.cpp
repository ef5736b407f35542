#include "validate/evidence/timeline.h"

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "validate/evidence/review.h"
#include "validate/text/escape.h"
#include "validate/text/json_object.h"
#include "validate/text/number_text.h"
#include "validate/verdicts/checks.h"

namespace backbend::validate {
namespace {

using Json = nlohmann::json;  // sorted keys

constexpr int kStillFrames = 48;  // two seconds, as the review clips hold their worst angle

Json rational_time(int frame) {
  return JsonObject<Json>()
      .with("OTIO_SCHEMA", "RationalTime.1")
      .with("rate", kFramesPerSecond)
      .with("value", frame);
}
Json time_range(int first, int frames) {
  return JsonObject<Json>()
      .with("OTIO_SCHEMA", "TimeRange.1")
      .with("start_time", rational_time(first))
      .with("duration", rational_time(frames));
}

/// What every object of a timeline has.
Json object(const char* schema, const std::string& name) {
  return JsonObject<Json>()
      .with("OTIO_SCHEMA", schema)
      .with("name", valid_utf8(name))
      .with("metadata", Json::object());
}
/// What every clip, gap, track and stack has besides.
Json item(const char* schema, const std::string& name) {
  Json json = object(schema, name);
  json["effects"] = Json::array();
  json["markers"] = Json::array();
  json["source_range"] = nullptr;
  return json;
}
Json gap(int frames) {
  Json json = item("Gap.1", "");
  json["source_range"] = time_range(0, frames);
  return json;
}
Json track(const std::string& name, Json children) {
  Json json = item("Track.1", name);
  json["kind"] = "Video";
  json["children"] = std::move(children);
  return json;
}
std::string timeline_text(const std::string& name, Json tracks) {
  Json stack = item("Stack.1", "tracks");
  stack["children"] = std::move(tracks);
  Json json = object("Timeline.1", name);
  json["global_start_time"] = nullptr;
  json["tracks"] = std::move(stack);
  return json.dump(2) + "\n";
}

const char* marker_color(Verdict verdict) {
  switch (verdict) {
    case Verdict::fail:
      return "RED";
    case Verdict::waived:
      return "YELLOW";
    case Verdict::stress:
      return "CYAN";
    case Verdict::not_measured:
      return "PURPLE";
    default:
      return "WHITE";
  }
}

/// A marker of `frames` frames that says what was found, where, and who must act.
Json marker(const Finding& finding, int frame, int frames) {
  const Check* check = find_check(finding.code);
  const std::string value = significant(finding.value) + " " + finding.unit;
  Json json = object("Marker.2", finding.code + (check ? " " + std::string(check->name) : "") +
                                     ": " + value + " (limit " + significant(finding.limit) + ")");
  const std::string owner(name_of(finding.owner));
  std::string note = finding.pose + ", rig " + finding.rig;
  if (!finding.joint.empty()) note += ", at " + finding.joint;
  note += ", " + owner;
  if (!finding.detail.empty()) note += ": " + finding.detail;
  json["comment"] = visible(note);
  json["color"] = marker_color(finding.verdict);
  json["marked_range"] = time_range(frame, frames);
  // Players that do not know a marker's comment show its metadata.
  json["metadata"]["backbend"] = JsonObject<Json>()
                                     .with("code", valid_utf8(finding.code))
                                     .with("control_deg", finding.control_deg)
                                     .with("note", visible(note))
                                     .with("owner", owner)
                                     .with("pose", valid_utf8(finding.pose))
                                     .with("reproduce", valid_utf8(finding.reproduce))
                                     .with("verdict", name_of(finding.verdict));
  return json;
}

std::string from_review(const std::string& path) {
  return valid_utf8(std::filesystem::path(path).lexically_relative("review").generic_string());
}

/// A numbered sequence of pictures: `FOLDER/extension.` 1001 `.png`.
struct PictureSequence {
  std::string folder, prefix, suffix;
  int first = 0, count = 0;
};

/// The sequence that these pictures are, named as a run names them; nullopt where they are none.
std::optional<PictureSequence> sequence_of(const std::vector<std::string>& pictures) {
  if (pictures.empty()) return std::nullopt;
  const std::string number = std::to_string(kFirstFrame);
  const std::size_t slash = pictures.front().rfind('/');
  const std::size_t at = pictures.front().rfind(number);
  if (slash == std::string::npos || at == std::string::npos || at < slash) return std::nullopt;
  const std::string before = pictures.front().substr(0, at);
  PictureSequence out{from_review(pictures.front().substr(0, slash)) + "/",
                      before.substr(slash + 1), pictures.front().substr(at + number.size()),
                      kFirstFrame, static_cast<int>(pictures.size())};
  for (int i = 0; i < out.count; ++i)
    if (pictures[static_cast<std::size_t>(i)] !=
        before + std::to_string(kFirstFrame + i) + out.suffix)
      return std::nullopt;
  return out;
}

Json sweep_clip(const Report& report, const RigResult& rig, const SweepSeries& sweep,
                const PictureSequence& sequence) {
  const auto of_rig = &rig - report.rigs.data(), of_sweep = &sweep - rig.sweeps.data();
  Json media = object("ImageSequenceReference.1", "");
  media["available_range"] = time_range(sequence.first, sequence.count);
  media["target_url_base"] = sequence.folder;
  media["name_prefix"] = valid_utf8(sequence.prefix);
  media["name_suffix"] = valid_utf8(sequence.suffix);
  media["start_frame"] = sequence.first;
  media["frame_step"] = 1;
  media["rate"] = kFramesPerSecond;
  media["frame_zero_padding"] = 4;
  media["missing_frame_policy"] = "error";
  Json clip = item("Clip.1",
                   rig.character + " " + rig.rig + " " + sweep.sweep + " (" + sweep.mapping + ")");
  clip["media_reference"] = std::move(media);
  clip["source_range"] = time_range(sequence.first, sequence.count);
  for (const Finding& finding : report.findings) {
    if (finding.at.rig != of_rig || finding.at.sweep != of_sweep) continue;
    const auto pose = static_cast<int>(nearest_pose(sweep.control_deg, finding.control_deg));
    clip["markers"].push_back(marker(finding, sequence.first + pose, 1));
  }
  return clip;
}

/// A clip, and what it lines up with on the other tracks.
struct PlacedClip {
  std::string rig, character, mapping;
  int frames = 0;
  Json clip;
};

std::vector<PlacedClip> sweep_clips(const Report& report) {
  std::vector<PlacedClip> clips;
  for (const RigResult& rig : report.rigs)
    for (const SweepSeries& sweep : rig.sweeps)
      if (const auto sequence = sequence_of(sweep.frame))
        clips.push_back({rig.rig, rig.character, sweep.mapping + " " + sweep.sweep, sequence->count,
                         sweep_clip(report, rig, sweep, *sequence)});
  return clips;
}

Json still(const std::string& name, const std::string& picture) {
  if (picture.empty()) return gap(kStillFrames);
  Json media = object("ExternalReference.1", "");
  media["available_range"] = time_range(1, kStillFrames);
  media["target_url"] = from_review(picture);
  Json clip = item("Clip.1", name);
  clip["media_reference"] = std::move(media);
  clip["source_range"] = time_range(1, kStillFrames);
  return clip;
}

}  // namespace

std::string sweeps_otio(const Report& report) {
  const std::vector<PlacedClip> clips = sweep_clips(report);
  if (clips.empty()) return "";
  std::vector<std::string> rigs;
  std::vector<std::pair<std::string, std::string>> places;  // character, mapping and sweep
  for (const PlacedClip& each : clips) {
    if (std::ranges::find(rigs, each.rig) == rigs.end()) rigs.push_back(each.rig);
    const std::pair place(each.character, each.mapping);
    if (std::ranges::find(places, place) == places.end()) places.push_back(place);
  }
  Json tracks = Json::array();
  for (auto rig = rigs.rbegin(); rig != rigs.rend(); ++rig) {
    Json children = Json::array();
    for (const auto& [character, mapping] : places) {
      int longest = 0;
      const PlacedClip* own = nullptr;
      for (const PlacedClip& each : clips) {
        if (each.character != character || each.mapping != mapping) continue;
        longest = std::max(longest, each.frames);
        if (each.rig == *rig) own = &each;
      }
      if (own != nullptr) children.push_back(own->clip);
      if (const int rest = longest - (own == nullptr ? 0 : own->frames); rest > 0)
        children.push_back(gap(rest));
    }
    tracks.push_back(track(*rig, std::move(children)));
  }
  return timeline_text(report.title + ": sweeps", std::move(tracks));
}

std::string findings_otio(const Report& report) {
  Json heat = Json::array(), compared = Json::array(), own = Json::array();
  for (const Finding& finding : report.findings) {
    const FindingPictures& pictures = finding.pictures;
    if (pictures.before.empty()) continue;
    const std::string name = finding.code + " " + finding.rig + ", " + finding.pose;
    const bool flip = !pictures.after.empty();
    own.push_back(still(name, pictures.before));
    own.back()["markers"].push_back(marker(finding, 1, kStillFrames));
    compared.push_back(
        still(flip ? name + ", after" : "rig " + pictures.other_rig + ", " + finding.pose,
              flip ? pictures.after : pictures.other));
    heat.push_back(still(pictures.heat_of, pictures.heat));
  }
  if (own.empty()) return "";
  Json tracks = Json::array();
  tracks.push_back(track("heat", std::move(heat)));
  tracks.push_back(track("compared with", std::move(compared)));
  tracks.push_back(track("this rig", std::move(own)));
  return timeline_text(report.title + ": findings", std::move(tracks));
}

}  // namespace backbend::validate
