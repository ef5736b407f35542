#pragma once
#include <optional>

#include "validate/prove/proof.h"

namespace backbend::validate {

/// Looks for a pose in a small box that breaks a claim, with the plain solver alone.
class Refuter {
 public:
  Refuter(const ProofQuestion& question, const solver::SpineSystem& system);

  /// Tries the box's middle, its corners and edges; a turn between two corners that the gain does
  /// not explain is bisected. Nullopt proves nothing.
  std::optional<Refutation> search(const SubBox& box) const;

  /// Measures at the pose what a refutation claims, anew: its value, or 0 where nothing shows.
  double measure(const Refutation& claim) const;

 private:
  using Pose = std::array<double, kProofAxes>;
  struct Turn {
    double angle = 0.0;  // in the channel's unit: degrees, or radians per length
    std::size_t joint = 0;
  };
  void solve(const Pose& pose, std::vector<glm::dquat>& turn) const;
  static Turn largest_turn(const std::vector<glm::dquat>& a, const std::vector<glm::dquat>& b);
  /// The gain along one axis near a pose, by a short step inside the box.
  Refutation gain_at(const Pose& pose, int axis, const SubBox& box) const;
  /// Halves the way between two poses that differ in one axis, always towards the larger turn.
  Refutation bisected(Pose from, Pose to, int axis) const;

  const ProofQuestion& question_;
  const solver::SpineSystem& system_;
  PoseOfBox controls_;
};

}  // namespace backbend::validate
