#pragma once
#include <span>
#include <vector>

#include "solver/rig/spine_pose.h"
#include "validate/metrics/math/rotation.h"
#include "validate/metrics/surface/spine_slices.h"

namespace backbend::validate {

/// What a pose means to do with the body, slice by slice. The mesh is judged against it: a surface
/// that bends because it was asked to is no fault.
struct BendIntent {
  std::vector<glm::dvec3> rest_tangent;  // of the intended curve at rest, unit
  std::vector<glm::dquat> frame;         // rotation from rest to pose that is meant for each slice
  std::vector<glm::dvec3> centre;        // where the slice's centre would be, moved rigidly by it
  // Turning beyond rest's, radians per unit of the spine's length, in rest space: a cross-section
  // displaced by o from the middle stretches by tangent . (bend x o) along the spine.
  std::vector<glm::dvec3> bend;
  double twist = 0.0;    // radians per unit of the spine's length, about the tangent
  double stretch = 1.0;  // of the body along the spine
};

/// A chain's pose and the curve it is meant to follow, as SpineSystem gives them.
struct IntentInput {
  const solver::SpinePose& pose;
  std::span<const glm::dvec3> intended;       // points at equal arc steps, hips first
  std::span<const glm::dvec3> intended_rest;  // as many
  double twist = 0.0;    // hips to chest, radians, as asked: tells 200 degrees from -160
  double window = 0.1;   // arc fraction over which a tangent turns: one bone
  double stretch = 1.0;  // length that is asked for, of rest
};

/// The ideal motion of the slices: frames carried along the intended curve without twist from the
/// hip's turn, then twisted evenly so that the last is the chest's turn. Slices beyond the chest go
/// rigidly with it.
BendIntent bend_intent(const SpineSlices& slices, const SlicePose& rest, const IntentInput& in);

/// The intent of a body that is asked nothing, or moved rigidly as a whole.
BendIntent no_intent(const SpineSlices& slices, const SlicePose& rest,
                     const solver::RigidMotion& moved = {});

}  // namespace backbend::validate
