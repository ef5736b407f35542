#pragma once
#include <optional>
#include <vector>

#include "skin/clip/clip.h"

namespace backbend::validate {

/// A recorded control at a frame, in its unit.
inline double control_value(const skin::Clip& clip, std::size_t frame, std::size_t control) {
  return clip.control_value[frame * clip.control.size() + control];
}

/// By how much a recorded control moves over a sweep, in its unit; 0 where nothing is said.
double control_range(const skin::Clip& clip, const skin::ClipSweep& range, std::size_t control);

/// The recorded control that moves furthest over a sweep: what its frames are named by. None where
/// none moves.
std::optional<std::size_t> leading_control(const skin::Clip& clip, const skin::ClipSweep& range);

/// How far the recorded channels of the body have gone at each frame of a sweep: degrees from its
/// first frame along their path. Empty where a frame does not say so, something else than a channel
/// moves, nothing does, or a step stands still or is more than three times as wide as most: then
/// only time tells how fast the body should turn.
std::vector<double> control_travel(const skin::Clip& clip, const skin::ClipSweep& range);

}  // namespace backbend::validate
