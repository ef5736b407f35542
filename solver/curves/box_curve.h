#pragma once
#include <vector>

#include "solver/math/box_arc.h"

namespace backbend::solver {

/// A curve of cubic Bezier pieces over a box of poses, asked by arc length as Curve is.
///
/// Which piece a place is on may change within a box: then it is the way over the first piece and
/// that over the next, each as far as it goes, which has no jump.
class BoxCurve {
 public:
  explicit BoxCurve(std::vector<std::array<BoxVector, 4>> piece, int panels = 32);

  const BoxReal& length() const { return length_; }
  const BoxVector& start() const { return piece_.front()[0]; }
  const BoxVector& end() const { return piece_.back()[3]; }
  /// The point at a share of the whole length, 0 to 1. Not finite where it was not enclosed.
  BoxVector point_at_share(double share) const;

 private:
  /// The parameter on one piece, below 0 or past 1 where the place is on another one.
  BoxReal parameter(std::size_t piece, double share) const;

  std::vector<std::array<BoxVector, 4>> piece_;
  std::vector<BoxArc> arc_;
  std::vector<BoxReal> before_, after_;  // length of the pieces before and after each
  BoxReal length_;
};

/// A vector over a box of poses of whose length more is known than its components say.
struct BoxStep {
  BoxVector way;
  BoxSlopes lengthening;  // way . d way / d y_j

  BoxReal length() const;
};

/// A chain whose bones turn each to its goal, and are as long as they are: the chase of
/// lay_chain(), over a box of poses. In any unit of length.
///
/// A joint stands past its goal, or short of it, along its bone. That one number is carried from
/// bone to bone: enclosures of the joints themselves would widen in every direction with each.
class BoxChase {
 public:
  BoxChase() : past_(0.0) {}

  /// One bone on, whose goal lies `step` from the goal before it.
  void go(const BoxStep& step, const BoxReal& bone);
  const BoxVector& aim() const { return aim_; }  // of the last bone, unit
  const BoxReal& past() const { return past_; }  // how far its end is past its goal, along it

 private:
  BoxVector aim_;
  BoxReal past_;
};

}  // namespace backbend::solver
