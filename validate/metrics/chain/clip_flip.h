#pragma once
#include <span>

#include "validate/metrics/chain/flip.h"

namespace backbend::validate {

/// Rotations of a baked clip: `turn[frame * joint_count + joint]`, unit, each joint in the space
/// that it is watched in: of the joint below it, of the hips, or of the world.
struct ClipMotion {
  std::size_t joint_count = 0;
  std::span<const glm::dquat> turn;
  std::span<const double> time;  // seconds, rising, one per frame
};

struct ClipSettings {
  // Jumps of 8 degrees are to be found in calm motion; what a float file rounds and what the pace
  // of a calm joint varies by takes less than a degree off them.
  double smallest_deg = 7.0;
  // A step is a jump where it leaves the prediction by more than this many times what the paces
  // around it vary by (plus a degree). Captured dance and acrobatics at 24 to 120 frames a second,
  // and keyed game animation, reach 2.53; see docs/checks/flip.md.
  double outlier = 3.0;
  double calm_deg = 1.0;
  // Two frames in a row that turn by up to this, in one direction and at one pace to a fifth, are a
  // keyed leap: two keys of a game's attack. Behind it hides a flip of up to twice that, and that
  // only where a player shows it just half way.
  double two_frames_deg = 45.0;
  double out_and_back = 1.4;  // times as much for a turn that is taken back
  // ... at a clip's ends, where a motion that begins or is cut off looks like a jump.
  double at_end = 2.2;
  // However lively a clip: no motion changes its pace by more than this from frame to frame.
  double largest_deg = 135.0;
  int reach = 4;         // steps to either side whose paces count as "around"
  int median_reach = 8;  // steps to either side whose median pace they are compared with
  int longest_out = 4;   // frames that a joint may stay away for "out and back" to be one event
};

/// Fewer frames have no pace to compare a step with.
inline constexpr std::size_t kLeastFrames = 5;

/// No two rotations are further apart: what is found only above it is not found at all.
inline constexpr double kAnyJump_deg = 180.0;

/// The discrete test for baked motion. Frames cannot be bisected, so this is an outlier test and no
/// certificate. Per joint and step from frame to frame:
///
///     predicted turn  the pace (turn per second) interpolated between the steps before and after,
///                     linear or, over two steps on either side, cubic: the nearer one counts
///     size            angle between the step and the predicted one, up to 180 degrees
///     jump            size > max(smallest, outlier (spread + calm)), at most `largest`
///     spread          the largest distance of the paces within `reach` steps from the median pace
///                     within `median_reach` steps, times the step's duration
///
/// The step under trial counts neither for its prediction nor for its spread, so no jump hides
/// itself; jumps that were found are replaced by their prediction before the next one is looked
/// for. A step, and a turn that is taken back within `longest_out` frames (a pop), are tried as two
/// explanations of the same place; the one that leaves less is taken. Where the motion around
/// explains that, up to three pops together are tried, and a pop of one frame next to an end.
/// Paces are compared in the space that the joint turns in and in its own, for a turn that is
/// multiplied on from either side keeps them in one of the two. Paces are per second, so uneven
/// keys do not count as jumps; q and -q are one rotation.
///
/// Jumps of several joints between the same two frames are one, of all of them. A clip of fewer
/// than kLeastFrames has no jumps, detects none (detectable_deg infinite) and is not certified.
FlipReport find_clip_flips(const ClipMotion& clip, const ClipSettings& settings = {});

}  // namespace backbend::validate
