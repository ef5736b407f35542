#pragma once
#include <span>
#include <string>
#include <vector>

#include "validate/metrics/rotation.h"

namespace backbend::validate {

/// Joint rotations of a baked clip: `turn[frame * joint_count + joint]`, unit, each joint in the
/// space of the one below it (or the hips), so that the body's own travel is no motion here.
struct ClipMotion {
  std::size_t joint_count = 0;
  std::span<const glm::dquat> turn;
  std::span<const double> time;  // seconds, rising, one per frame
};

struct ClipSettings {
  // A change of pace below this is never called a jump. Fast but real motion of shoulders and neck
  // in captured dance and acrobatics reaches 33 degrees a frame at 24 frames a second; the jumps of
  // interpolation are 60 and more.
  double smallest_deg = 45.0;
  double outlier = 8.0;  // times the clip's own pace changes around it
  int reach = 6;         // frames to either side that "around it" means
};

struct ClipJump {
  std::size_t joint = 0;
  std::size_t frame = 0;      // the jump lies between this frame and the next
  double size_deg = 0.0;      // beyond what the motion on both sides explains
  double expected_deg = 0.0;  // the largest that the clip's own motion explains there
};

/// Jumps of a clip, by rising frame, then joint.
struct ClipReport {
  std::vector<ClipJump> jumps;
  /// Per joint: the smallest jump that would have been found at its busiest place, degrees. What is
  /// smaller than this cannot be told from the motion, whatever it is.
  std::vector<double> detectable_deg;
  bool finite = true;
  std::size_t not_finite_frame = 0;
};

/// The discrete test for baked motion. Frames cannot be bisected, so this is an outlier test and no
/// certificate: a step is a jump if it differs from the mean of the steps before and after it by
/// more than `smallest_deg` and by more than `outlier` times the median such difference of the
/// frames around. Steps are compared per second, so uneven keys are no jumps; q and -q are one
/// rotation; the neighbours of a jump, which differ from it too, are not counted again.
///
/// A clip of fewer than five frames has no jumps, and detects none (detectable_deg infinite).
ClipReport find_clip_flips(const ClipMotion& clip, const ClipSettings& settings = {});

}  // namespace backbend::validate
