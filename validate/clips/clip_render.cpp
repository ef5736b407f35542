#include "validate/clips/clip_render.h"

#include <algorithm>
#include <stdexcept>

#include "skin/character/printable.h"
#include "validate/evidence/worst_metric.h"
#include "validate/files/hash.h"
#include "validate/judge/judge_recorded.h"
#include "validate/model/report.h"

namespace backbend::validate {

using Index = std::size_t;
using skin::CharacterError;

ClipPoses::ClipPoses(const ClipFiles& files) : input_(read_clip_input(files)) {
  const skin::Clip& clip = input_.clip;
  if (input_.stage == nullptr)
    throw CharacterError(clip.file_name +
                         ": no body to take pictures of; specify the character that it moves");
  if (clip.sweeps.size() > 1) {
    std::string names;
    for (const skin::ClipSweep& each : clip.sweeps)
      names += (names.empty() ? "" : ", ") + skin::in_quotes(each.name);
    throw CharacterError(clip.file_name + ": has several sweeps; choose one with --clip: " + names);
  }
  poses_ = plan_sweep(clip, sweep());
  for (Index i = 0; i < poses_.poses.size(); ++i)
    frame_numbers_.push_back(poses_.poses[i].frame.value_or(static_cast<int>(i)));
  body_ =
      std::make_unique<const ClipBody>(stage().character(), stage().anatomy(), clip, files.names);
  system_ = std::make_unique<const ClipSystem>(stage().character(), stage().anatomy(), *body_);
}

std::string ClipPoses::rig() const { return input_.clip.name; }

std::string ClipPoses::inputs() const {
  const skin::Character& character = stage().character();
  const skin::Clip& clip = input_.clip;
  std::string out = hash_text(character.content_hash_high, character.content_hash_low) + "|" +
                    hash_text(clip.content_hash_high, clip.content_hash_low) + "|" + sweep().name;
  // Which of the clip's joints stands for which of the character's shows in the poses alone.
  for (const glm::dmat4& world : body_->world_from_node(0))
    for (int c = 0; c < 4; ++c)
      for (int r = 0; r < 3; ++r) out += "|" + number_text(world[c][r], 9);
  return content_hash(out);
}

std::vector<render::Attribute> ClipPoses::attributes() const {
  const skin::Clip& clip = input_.clip;
  return {{"backbend/rig", rig()},
          {"backbend/clip", clip.file_name},
          {"backbend/clipHash", hash_text(clip.content_hash_high, clip.content_hash_low)},
          {"backbend/sweep", sweep().name}};
}

PosedCharacter ClipPoses::posed(Index pose) const {
  const Index frame = sweep().first + pose;
  return {system_->pose(frame), body_->world_from_node(frame), body_->mesh(frame), nullptr};
}

std::string ClipPoses::text(Index pose) const { return frame_text(poses_, pose); }

std::vector<float> ClipPoses::strain(const BodyMetrics& body, Index pose,
                                     const PosedCharacter& posed) const {
  const Index frame = sweep().first + pose;
  const std::vector<double> control = {static_cast<double>(frame)};
  return body.strain_heat(rig_at_rest(*system_), control, posed.spine, posed.mesh,
                          glm::radians(system_->twist_deg(frame)));
}

std::string ClipPoses::worst_metric(Index pose, const PosedCharacter& /*posed*/) const {
  const BodyMetrics metrics(stage().character(), stage().anatomy(), stage().driver());
  PoseRecord record = poses_.poses[pose];
  measure_frame(*body_, *system_, rig_at_rest(*system_), &metrics, record);
  const MetricScope scope{system_->rest(), metrics.scope()};
  return worst_of(record, clip_limits(),
                  [&](const Metric& metric) { return is_applicable(metric, scope, record); });
}

Index ClipPoses::pose_of_frame(int number) const {
  const auto found = std::ranges::lower_bound(frame_numbers_, number);
  if (found == frame_numbers_.end() || *found != number)
    throw std::invalid_argument(std::to_string(number) + ": the clip has the frames " +
                                std::to_string(frame_numbers_.front()) + " to " +
                                std::to_string(frame_numbers_.back()));
  return static_cast<Index>(found - frame_numbers_.begin());
}

}  // namespace backbend::validate
