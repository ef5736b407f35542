#include "validate/clips/clip_canary.h"

#include <algorithm>
#include <cmath>

#include "validate/metrics/chain/clip_flip.h"

namespace backbend::validate {

using Index = std::size_t;

CanaryResult clip_canary(const RigRecord& record, const skin::Clip& clip, const ClipBody& body,
                         const skin::Anatomy& anatomy) {
  const SweepRecord& sweep = *std::ranges::max_element(
      record.sweeps, {}, [](const auto& each) { return each.poses.size(); });
  const std::vector<WatchedJoint>& watched = record.recording->watched;
  CanaryResult result;
  result.rig = "clip_half_turn";
  result.code = "BB001";
  const Index count = watched.size(), joint = anatomy.chest_index / 2 + 1;
  const Index frames = sweep.poses.size(), at = frames / 2;
  result.joint = watched[joint].name;
  result.expected_deg = sweep.poses[at].frame.value_or(static_cast<int>(at));
  result.found_deg = std::nan("");
  const skin::ClipSweep range{sweep.sweep.name, frame_of(sweep.poses.front()), frames};
  std::vector<glm::dquat> turns = watched_turns(body, watched, range);
  // About the bone, as up vectors and hemispheres flip.
  const solver::SpinePose& rest = record.system->rest();
  const Index bone = std::min(joint, rest.position.size() - 2);
  const glm::dquat flip =
      rotation(glm::normalize(rest.position[bone + 1] - rest.position[bone]) * kPi);
  for (Index f = at; f < frames; ++f) turns[f * count + joint] = turns[f * count + joint] * flip;
  const std::span<const double> time(clip.time);
  const FlipReport found = find_clip_flips({count, turns, time.subspan(range.first, frames)});
  const auto is_there = [&](const FlipReport& flips) {
    return std::ranges::any_of(flips.jumps, [&](const Jump& jump) {
      return jump.pose + 1 == at &&
             std::ranges::find(jump.joints, joint, &JointJump::joint) != jump.joints.end();
    });
  };
  result.found = is_there(found);
  if (result.found) result.found_deg = result.expected_deg;
  result.twin_clean = !is_there(sweep.flips);
  result.detail = "half a turn of " + result.joint + " from frame " +
                  number_text(result.expected_deg, 0) + " on " +
                  (result.found ? "is found" : "is not found") +
                  (result.twin_clean ? "" : "; the clip jumps there by itself");
  return result;
}

}  // namespace backbend::validate
