#pragma once
#include <cstddef>

#include "solver/rig/spine_pose.h"

namespace backbend::validate {

inline constexpr std::size_t kLeastForCorners = 5;  // joints: three inner ones

/// By how much one joint of a chain turns against the mean of itself and its neighbours, rest taken
/// off, degrees: half of what a joint turns alone, nothing for an even bend. For rigs of which no
/// curve is known that their chain should follow. NaN for a chain of fewer than kLeastForCorners
/// joints. `joint` is where.
double chain_corner(const solver::SpinePose& pose, const solver::SpinePose& rest, int& joint);

}  // namespace backbend::validate
