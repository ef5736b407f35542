#pragma once
#include <array>
#include <glm/vec3.hpp>

#include "solver/math/even_weight.h"

namespace backbend::solver {

struct EvenWeights;

/// A turn laid over an `even` spine: at arc fraction s by the rotation vector
/// bump(0, s) v[0] + bump(1, s) v[1], radians, outermost below Lower. Nothing at the ends.
struct ReachField {
  std::array<glm::dvec3, 2> v{};

  bool none() const { return v[0] == glm::dvec3(0.0) && v[1] == glm::dvec3(0.0); }
  glm::dvec3 at(double s) const;
};

/// The two bumps: a lean, 16 s^2 (1-s)^2, and an S, twice that times (1 - 2s). Both vanish with
/// their slopes at the hips and the chest.
double reach_bump(int which, double s);

/// How `even` brings the chest back towards the three-bone tip: one damped least-squares step on
/// the two bumps, held inside what the joints have left of their largest angle. docs/even.md
/// derives the bounds.
class EvenReach {
 public:
  /// `reach` 0..1; `max_joint` the largest angle at a joint, radians; `peak_step[ch]` the most that
  /// channel ch's weight rises over a joint; `bones` the joints' number.
  EvenReach(double reach, double max_joint, const std::array<double, 6>& peak_step, int bones);

  bool off() const { return reach_ == 0.0; }

  /// The field for a spine of unit length whose chest misses the three-bone tip by `gap`, with
  /// moment[i] the integral of bump i times the posed tangent. `upper` are Middle's and Top's
  /// channels, radians. Once continuously differentiable in all of them; 0 for a gap of 0.
  ReachField field(const glm::dvec3& gap, const std::array<glm::dvec3, 2>& moment,
                   const std::array<double, 6>& upper) const;

  /// The most that a frame can turn for a turn of 1 of a channel. `weight` is the channel's;
  /// `lever` how far the three-bone tip is from its control, in spine lengths.
  double gain_bound(int channel, const EvenWeight& weight, double lever) const;

  /// The most that the field adds to a joint's angle.
  double joint_share(const ReachField& field) const;

 private:
  /// What the joints have left for the field, as the largest size of (v[0], v[1]).
  double room(const std::array<double, 6>& upper) const;

  double reach_, max_joint_;
  std::array<double, 6> peak_step_;
  double bump_step_ = 0.0;  // the most that (bump 0, bump 1) changes over a joint
};

}  // namespace backbend::solver
