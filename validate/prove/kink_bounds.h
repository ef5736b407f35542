#pragma once
#include <cstddef>
#include <glm/vec3.hpp>
#include <span>

#include "solver/curves/box_course.h"

namespace backbend::validate {

/// What BB010 can be, degrees, at every pose at which a chain lies so on its intended curve, of
/// which the check takes `points` points. `rest_excess` as rest_excess() gives it, one for each
/// joint. Its least is 0 and its most infinite where nothing better is known.
///
/// The check compares neighbouring bones with chords of the curve between places that it finds by
/// the chain's own length. How far these are from joints on the curve follows from how much longer
/// each arc can be than its bone; what a chord turns by as its ends move, from how the curve bends.
/// Where a chain comes with its chords, the check's formula is evaluated.
///
/// A curve that comes back to the place where its chain begins or ends is left out: there the
/// nearest place, which the check asks for, could be another.
/// A most no larger than `enough` is not narrowed further.
solver::Interval kink_over(const solver::BoxCourse& course, std::span<const glm::dvec3> rest_excess,
                           std::size_t points, double enough = 0.0);

}  // namespace backbend::validate
