#pragma once
#include <glm/mat3x3.hpp>
#include <span>

#include "solver/rig/spine_pose.h"
#include "validate/metrics/math/rotation.h"

namespace backbend::validate {

/// The rotation nearest to a linear map (its polar factor), unit; a mirrored or collapsed map has
/// none, and gives a quaternion that is not finite.
/// Source: N. Higham, "Computing the polar decomposition", SIAM J. Sci. Stat. Comput. 7, 1986.
glm::dquat nearest_rotation(const glm::dmat3& map);

/// The rigid motion that takes points nearest to where they went, in weighted squares; rest_origin
/// is their weighted centre at rest. One point, or points on a line, leave the turn about it open:
/// the least turn is given. Not finite where the weights sum to nothing.
/// Source: P. Davenport's q-method; B. Horn, "Closed-form solution of absolute orientation using
/// unit quaternions", JOSA A 4, 1987.
solver::RigidMotion fit_rigid(std::span<const glm::dvec3> rest, std::span<const glm::dvec3> posed,
                              std::span<const double> weight);

}  // namespace backbend::validate
