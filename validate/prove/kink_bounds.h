#pragma once
#include <cstddef>
#include <span>

#include "solver/curves/box_course.h"

namespace backbend::validate {

/// The most that BB010 can be, degrees, at every pose at which a chain lies so on its intended
/// curve, of which the check takes `points` points. `rest_excess` as rest_excess() gives it, one
/// for each joint. Infinite where no bound is known.
///
/// The check compares neighbouring bones with chords of the curve between places that it finds by
/// the chain's own length. How far these are from the joints follows from how much longer each arc
/// can be than its bone; what a chord turns by as its ends move, from how the curve bends.
///
/// A curve that comes back to the place where its chain begins or ends is left out: there the
/// nearest place, which the check asks for, could be another.
/// A bound no larger than `enough` is not narrowed further.
double most_kink(const solver::BoxCourse& course, std::span<const double> rest_excess,
                 std::size_t points, double enough = 0.0);

}  // namespace backbend::validate
