#include "validate/clips/clip_images.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "validate/evidence/image_witness.h"

namespace backbend::validate {
namespace {

using Index = std::size_t;

PosedCharacter posed_at(const ClipScene& scene, Index frame) {
  return {scene.system().pose(frame), scene.body.world_from_node(frame), scene.body.mesh(frame),
          nullptr};
}

/// The box of some frames and the rest pose.
render::Bounds box_of(const ClipScene& scene, const std::vector<PosedCharacter>& frames) {
  render::Bounds box = scene.stage.bounds(scene.stage.rest());
  for (const PosedCharacter& each : frames) box.add(scene.stage.bounds(each.mesh));
  return box;
}

ImageWitness witness_jump(const ClipScene& scene, const SweepRecord& sweep, Index pose) {
  constexpr Index kReach = 8;  // frames on either side that say how the motion usually changes
  const Index first = pose - std::min(pose, kReach);
  const Index end = std::min(sweep.poses.size(), pose + kReach + 1);
  std::vector<PosedCharacter> frames;
  for (Index i = first; i < end; ++i) frames.push_back(posed_at(scene, frame_of(sweep.poses[i])));
  Photographer camera(scene.stage, box_of(scene, frames));
  std::vector<double> change;
  std::optional<PoseViews> before;
  ImageReading at_jump;
  for (Index i = 0; i < frames.size(); ++i) {
    poll_interrupt();
    PoseViews now = take_views(camera, frames[i], i > 0 ? &frames[i - 1] : nullptr);
    const ImageReading reading = i > 1 ? motion_change(*before, now) : ImageReading{};
    change.push_back(std::isnan(reading.value) ? 0.0 : reading.value);
    if (first + i == pose) at_jump = reading;
    before.emplace(std::move(now));
  }
  const std::vector<double> score = pop_scores(change);
  if (!std::isnan(at_jump.value)) at_jump.value = score[pose - first];
  ImageWitness witness = witness_of(at_jump, "pop_score", kPopScore);
  witness.note = "how far the change of the picture's motion at this step stands out from the " +
                 std::to_string(frames.size()) + " frames around it, robust standard deviations";
  return witness;
}

}  // namespace

ImageWitness clip_witness(const ClipScene& scene, const SweepRecord& sweep,
                          const Finding& finding) {
  const auto pose = static_cast<Index>(finding.at.pose);
  const Index frame = frame_of(sweep.poses[pose]);
  const Witness pictures = find_check(finding.code)->pictures;
  if (pictures == Witness::jump && pose > 1) return witness_jump(scene, sweep, pose);
  if (pictures != Witness::kink && pictures != Witness::slices) {
    ImageWitness none;
    none.note = "no picture metric of clips looks at this";
    return none;
  }
  const std::vector<glm::dmat4> even =
      even_bend(scene.stage.character(), scene.stage.anatomy(), scene.system(), scene.body, frame);
  const ClipSystem ideal(scene.stage.character(), scene.stage.anatomy(), even);
  const std::vector<PosedCharacter> both = {
      posed_at(scene, frame), {ideal.pose(0), even, scene.body.blended(even), nullptr}};
  Photographer camera(scene.stage, box_of(scene, both));
  const PoseViews here = take_views(camera, both[0]), there = take_views(camera, both[1]);
  ImageWitness witness =
      pictures == Witness::kink
          ? witness_of(tilt_jump(here, there), "tilt_jump_deg", kVisibleTiltDeg)
          : witness_of(narrowing(here, there), "narrowing_percent", kVisibleNarrowing);
  witness.note = std::string(pictures == Witness::kink ? "the sharpest change of the torso's tilt"
                                                       : "how much narrower the torso is") +
                 " against an even bend with the same ends and weights";
  return witness;
}

}  // namespace backbend::validate
