#pragma once
#include "solver/math/box_number.h"

namespace backbend::solver {

/// How fast a frame turns that is handed on from bone to bone by shortest arcs, over a box of
/// poses: transport_along()'s.
///
/// About a bone the frame turns as far as the arcs from the first on roll it, across the bone as
/// the bone does. A product of the arcs' rates would widen with every bone.
class BoxRoll {
 public:
  /// `turn` of the frame before the first bone, whose X axis is `direction` at rest.
  BoxRoll(const BoxTurn& turn, const glm::dvec3& direction);

  /// On to a bone along unit `direction`.
  void go(const BoxVector& direction);
  /// The same, where `turned`, the new direction less the last one, is known better than both.
  void go(const BoxVector& direction, const IntervalVector& turned);

  const BoxVector& direction() const { return direction_; }
  /// How fast the frame turns, rolled about its bone by `twist` more.
  BoxRates rates(const BoxReal& twist = 0.0) const;

 private:
  void go_on(const BoxVector& direction, const BoxSlopes& rolled);

  BoxVector direction_;
  BoxSlopes roll_;
};

/// That frame itself.
class BoxTransport {
 public:
  /// As BoxRoll's.
  BoxTransport(const BoxTurn& turn, const glm::dvec3& direction);

  void go(const BoxVector& direction);
  /// From rest. Rates are those of its components.
  const BoxTurn& turn() const { return turn_; }

 private:
  BoxTurn turn_;
  BoxVector direction_;
};

}  // namespace backbend::solver
