#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "solver/rig/box_solver.h"

namespace backbend::validate {

/// A motion as it is seen by what moves with `base`.
struct MotionPair {
  std::uint16_t base, motion;

  bool operator==(const MotionPair&) const = default;
};

/// For each of some pairs of rigid motions, over a box of poses, enclosures of what `motion` does
/// after `base` was undone: rest space of `base`.
class RelativeMotions {
 public:
  RelativeMotions(std::span<const solver::BoxMotion> motions, std::span<const MotionPair> pairs);

  /// The turn of a vector by pair number `pair`.
  solver::IntervalVector turn(std::size_t pair, const glm::dvec3& vector) const;
  /// How far a point is moved from its place.
  solver::IntervalVector shift(std::size_t pair, const glm::dvec3& point) const;

  /// The same with derivatives: column `axis` of the turn less the identity, and a point's shift.
  const solver::BoxVector& excess(std::size_t pair, std::size_t axis) const {
    return relative_[pair].box_excess[axis];
  }
  solver::BoxVector box_shift(std::size_t pair, const glm::dvec3& point) const;

 private:
  struct Relative {
    bool same;          // no motion
    glm::dvec3 origin;  // at rest
    // Columns of the turn less the identity, and the way of the origin.
    std::array<solver::BoxVector, 3> box_excess;
    solver::BoxVector box_way;
    std::array<solver::IntervalVector, 3> excess;
    solver::IntervalVector way;
  };
  std::vector<Relative> relative_;
};

}  // namespace backbend::validate
