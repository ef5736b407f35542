#pragma once
#include <array>

#include "solver/math/box_number.h"

namespace backbend::solver {

/// A cubic Bezier and its straight continuation past the end, over a box of poses: where bones that
/// are walked along it meet it. Curve::step_to_distance(), with proof.
///
/// The continuation's parameter runs on from 1 as fast as the curve's does at its end.
class BoxWalk {
 public:
  explicit BoxWalk(const std::array<BoxVector, 4>& cv);

  BoxVector point(const BoxReal& u) const;
  /// The way from the place at u to that at v, over v - u: the mean velocity between them. Far
  /// narrower than the difference of two points.
  BoxVector chord(const BoxReal& u, const BoxReal& v) const;

  /// The parameter of the first place after `from` that is `distance` away from it, above 0. Not
  /// finite where it was not proved that there is one at every pose, and that the curve does not
  /// turn by a right angle before it.
  BoxReal step(const BoxReal& from, const BoxReal& distance) const;

 private:
  BoxVector velocity(const BoxReal& u) const;
  /// step() at the box's middle, in plain numbers.
  double guess(double from, double distance) const;

  std::array<BoxVector, 4> cv_;
  BoxVector end_velocity_;
  std::array<glm::dvec3, 4> middle_;  // of the points, at the box's middle
};

}  // namespace backbend::solver
