#pragma once
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "solver/curves/curve.h"

namespace backbend::solver {

/// Arc lengths of the first and the last joint of a walked chain; outside 0..length on the straight
/// continuations past the ends.
struct Walk {
  double from_arc = 0.0;
  double to_arc = 0.0;
};

/// What is known of each joint of a walked chain besides its place.
struct WalkDetail {
  std::vector<double> arc;  // its arc length
  /// How far it, and the joints before it, are from a jump: a bone that meets the curve square to
  /// its tangent may as well meet a later part of it. In radians: kPi while the bone and the
  /// tangent are within 60 degrees, from there falling with the square of the cosine.
  std::vector<double> margin;
};

/// Lays a chain on a curve: each joint on the curve (or its straight continuation) at its bone's
/// length from the one before, starting at arc length `from_arc`. `joint` gets bone.size() + 1
/// places; `detail`, where not null, the rest. On a curve that is a single point all stay there.
Walk walk_from(const Curve& curve, std::span<const double> bone, double from_arc,
               std::vector<glm::dvec3>& joint, WalkDetail* detail = nullptr);

/// walk_from() with the end that stays put chosen by `lead`: 0 starts at the curve's start, 1
/// starts where the chain's last joint meets the curve's end, between them linear. `slide` is added
/// to the start's arc length. `backwards` is the same curve from its end.
Walk walk_led(const Curve& curve, const Curve& backwards, std::span<const double> bone, double lead,
              double slide, std::vector<glm::dvec3>& joint, WalkDetail* detail = nullptr);

}  // namespace backbend::solver
