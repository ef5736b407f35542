#pragma once
#include <array>
#include <memory>
#include <vector>

#include "solver/math/interval.h"

namespace backbend::validate {

/// A bone along a X + b c, not of unit length, where X is the fixed axis at rest and c the unit
/// vector that poses turn; with the derivatives of both by kappa = X . c.
struct PlaneBone {
  solver::Interval a, b, a_by, b_by;
};

/// A chain all of whose bones lie in the plane of X and c, and depend on the pose by kappa alone.
/// Written apart from the solver's own code.
class PlaneChain {
 public:
  virtual ~PlaneChain() = default;
  /// The bones, first to last, for every kappa of an interval above -1; empty where they could not
  /// be enclosed. `panels`: PlaneCurve's.
  virtual std::vector<PlaneBone> bones(const solver::Interval& kappa, int panels) const = 0;
};

/// Bones between equal shares of the length of the curve between hips and chest, of these depths.
std::unique_ptr<PlaneChain> chain_of_shares(int bones, double hip_depth, double chest_depth);

/// Bones walked along that curve from its start, each a straight line of an equal part of the
/// curve's length; past its end straight on.
std::unique_ptr<PlaneChain> chain_of_steps(int bones, double hip_depth, double chest_depth);

/// How the bones of a chasing chain get their length: from nine times the way to the first of nine
/// equal shares of the curve's length, or from that length.
enum class ChasedLength { nulls, arc };

/// Bones that chase equal shares of the length of a uniform cubic B-spline through the root, the
/// middles of three bones of these lengths on one line, and the tip, where the last one turns.
std::unique_ptr<PlaneChain> chain_that_chases(int bones, const std::array<double, 3>& length,
                                              ChasedLength rule);

}  // namespace backbend::validate
