#pragma once
#include "solver/math/box_number.h"

namespace backbend::solver {

/// A frame that is handed on from bone to bone by shortest arcs, over a box of poses:
/// transport_along() for its turn, and how fast it turns.
///
/// About a bone the frame turns as far as the arcs from the first on roll it, across the bone as
/// the bone does. A product of the arcs' rates would widen with every bone.
class BoxTransport {
 public:
  /// `turn` of the frame before the first bone, whose X axis is `direction` at rest.
  BoxTransport(const BoxTurn& turn, const glm::dvec3& direction);

  /// On to a bone along unit `direction`.
  void go(const BoxVector& direction);

  /// From rest. Rates are those of its components.
  const BoxTurn& turn() const { return turn_; }
  /// How fast it turns, rolled about its bone by `twist` more.
  BoxRates rates(const BoxReal& twist = 0.0) const;

 private:
  BoxTurn turn_;
  BoxVector direction_;
  BoxSlopes roll_;
};

}  // namespace backbend::solver
