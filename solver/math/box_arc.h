#pragma once
#include <array>
#include <vector>

#include "solver/math/box_number.h"

namespace backbend::solver {

/// Arc length of one cubic Bezier over a box of poses, with proof: what Curve finds by series and
/// Newton's method is enclosed here by panels with a remainder and by the interval Newton operator.
///
/// A curve whose speed may vanish somewhere, at some pose of the box, has no finite results.
class BoxArc {
 public:
  /// More panels cost as much more, and bring lengths nearer: their error falls with the square.
  explicit BoxArc(const std::array<BoxVector, 4>& cv, int panels = 32);
  /// Of the three legs of the curve's polygon.
  explicit BoxArc(const std::array<BoxVector, 3>& legs, int panels = 32);

  const BoxReal& length() const { return length_; }
  int panel_count() const { return panels_; }
  /// Up to the begin of a panel, and from there to the end; panels are of equal parameter.
  const BoxReal& until(int panel) const { return until_[std::size_t(panel)]; }
  const BoxReal& after(int panel) const { return after_[std::size_t(panel)]; }

  /// The parameter at arc length `s` from the start, on the polynomial's own continuation past 1.
  /// There is one, and one only, at every pose of the box; not finite where that was not proved.
  BoxReal parameter_at(const BoxReal& s) const;
  /// The parameter at a fixed share of the whole length, above 0 and below 1: narrower than
  /// parameter_at(share * length()), since no piece of the length counts twice. `before` and
  /// `after`: lengths of a longer curve that this is a piece of, and the share is of.
  BoxReal parameter_at_share(double share, const BoxReal& before = 0.0,
                             const BoxReal& after = 0.0) const;

 private:
  /// A coefficient vector: over the box, at its middle, and by each variable.
  struct Coefficient {
    IntervalVector value, center;
    std::array<IntervalVector, kBoxVariables> slope;
  };
  static Coefficient coefficient(const BoxVector& v);
  static IntervalVector at(const IntervalVector& a, const IntervalVector& b,
                           const IntervalVector& c, const Interval& u);

  /// Velocity over the box for parameters in `u` around `middle`.
  IntervalVector velocity(const Interval& u, double middle) const;
  /// d speed / d y_j over the box for parameters in `u`.
  Interval speed_slope(const Interval& u, const IntervalVector& velocity, const Interval& speed,
                       std::size_t j) const;
  /// The root near `guess` of a length that grows with the parameter as the arc does, where `error`
  /// is the length at the guess.
  BoxReal root_near(double guess, const BoxReal& error) const;
  /// Which panel holds a length at the box's middle, and the parameter there at even speed.
  struct Guess {
    std::size_t panel;
    double parameter;
  };
  Guess guess_at(double length) const;
  /// Arc length between two parameters. Cut finer where the speed varies much.
  BoxReal piece(double from, double to, int depth = 0) const;

  int panels_;
  std::vector<BoxReal> panel_;  // arc length of each
  Coefficient a_, b_, c_;       // velocity a + b u + c u^2
  std::vector<BoxReal> until_;  // up to each panel's begin, then the whole; the first is 0
  std::vector<BoxReal> after_;  // from each panel's begin to the end; the last is 0
  BoxReal length_;
};

}  // namespace backbend::solver
