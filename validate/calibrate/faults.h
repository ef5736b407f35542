#pragma once
#include <span>
#include <vector>

#include "skin/character/character.h"
#include "solver/rig/spine_pose.h"
#include "validate/metrics/chain/flip.h"
#include "validate/metrics/surface/spine_slices.h"

namespace backbend::validate {

// Faults of known size and place, put into poses that have none. `fraction` is the arc fraction of
// each joint of a pose, hips first.

/// Bends a chain at an arc fraction by a rotation vector (world space) beyond what it was bent, and
/// takes the same off in even parts at all joints: the total bend is kept. Chest and arms go along
/// with the last joint.
void inject_kink(solver::SpinePose& pose, std::span<const double> fraction, double at,
                 const glm::dvec3& kink);

/// Rolls the joints between two arc fractions about their own rest direction, radians.
void inject_roll(solver::SpinePose& pose, const solver::SpinePose& rest,
                 std::span<const double> fraction, double from, double to, double roll);

/// Turns the arms by a rotation vector about their root, and shifts the root.
void inject_arm_drift(solver::SpinePose& pose, const glm::dvec3& turn, const glm::dvec3& shift);

/// A rig whose joint turns by a rotation vector at t and stays so.
FlipRig inject_flip(FlipRig rig, std::size_t joint, double t, const glm::dvec3& turn);

/// Draws the surface toward the middle of a slice so that the slice loses a share of its area; the
/// loss fades to nothing over `reach` (length) along the slice's normal.
void inject_slice_loss(std::vector<glm::vec3>& position, const SlicePose& pose, std::size_t slice,
                       double share, double reach);

/// Binds one vertex to one joint alone.
void bind_vertex(skin::Influences& influences, std::uint16_t joint);
/// Scales the weights of one vertex so that they sum to this.
void scale_weights(skin::Influences& influences, double sum);

}  // namespace backbend::validate
