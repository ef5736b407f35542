#pragma once
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "solver/rig/spine_system.h"
#include "validate/hunt/control_box.h"
#include "validate/hunt/pose_search.h"
#include "validate/metrics/chain/flip.h"

namespace backbend::validate {

/// A short straight path between two poses of a box, across a place where a chain may flip.
struct FlipPath {
  PoseDegrees from, to;    // in the digits of a suite's file
  std::vector<double> at;  // the place itself, a point of the box
  double jump_deg = 0.0;   // the largest on it; 0: none
  double gain = 0.0;       // degrees of turn per degree of the path, jumps apart
};

/// Finds the paths on which the chain of a system jumps, or moves too fast, from what a search
/// noticed. Only the chain is solved.
class FlipHunt {
 public:
  /// `gain_limit`: BB002's; slower paths are left out. `evaluations`: solves that may be spent on
  /// following the gain; those of find_flips(), which confirm, are counted apart. Keeps references.
  FlipHunt(const solver::SpineSystem& system, solver::Mapping mapping, const ControlBox& box,
           double gain_limit, std::size_t evaluations);

  /// Paths across the suspects and across the jumps on the axes through rest: jumps first, those
  /// nearest to rest first, none beside another. Suspects that do not jump, and the pose of least
  /// flip margin (where the rig has margins), are followed uphill: to where the margin is least, or
  /// the chain turns fastest.
  std::vector<FlipPath> paths(const std::vector<Suspect>& suspects,
                              const std::optional<std::vector<double>>& least_margin);

  /// How far the path may be moved along each axis that it does not run along, to both sides
  /// together, so that the jump (or else a gain above the limit) is still met; degrees by axis.
  void measure_width(const FlipPath& path, bool jump, std::map<std::string, double>& width_deg);

  std::size_t spent() const { return spent_; }
  std::size_t confirmations() const { return confirmations_; }

 private:
  std::vector<double> sharpened(std::vector<double> at, std::size_t budget);
  double steepness(const std::vector<double>& at, double reach);
  double least_margin(const std::vector<double>& at);
  std::optional<FlipPath> path_through(const std::vector<double>& at,
                                       const std::vector<double>& direction_deg);
  std::vector<FlipPath> on_axes();
  FlipReport flips_on(const PoseDegrees& from, const PoseDegrees& to);
  void pose_at(const std::vector<double>& at, solver::SpinePose& pose) const;

  const solver::SpineSystem& system_;
  solver::Mapping mapping_;
  const ControlBox& box_;
  const double gain_limit_;
  std::size_t left_, spent_ = 0, confirmations_ = 0;
};

}  // namespace backbend::validate
