#pragma once
#include <array>
#include <span>
#include <vector>

namespace backbend::solver {

/// How far a control has taken hold at arc fraction s: W rises monotonically from 0 (hips) to 1
/// (chest). Immutable; a value.
///
/// Both kinds are exactly 0 at s = 0 and exactly 1 at s = 1, so the chest carries the whole
/// control.
class EvenWeight {
 public:
  /// The slope rises over an eighth of the span, stays, and falls over an eighth; both ramps are
  /// cubic smoothsteps, so W is twice continuously differentiable and its second derivative
  /// Lipschitz. Needs 0 <= from < to <= 1. Peak slope 8 / (7 (to - from)).
  static EvenWeight trapezoid(double from, double to);
  /// The slope is proportional to `density` at equal arc steps from hips to chest, straight between
  /// them; one value is an even slope. W is once continuously differentiable. Needs at least one
  /// value, all >= 0 and finite, not all 0.
  static EvenWeight from_density(std::span<const double> density);

  double operator()(double s) const;
  double slope(double s) const;
  double peak_slope() const { return peak_; }
  /// The largest slope on a stretch.
  double peak_slope(double from, double to) const;
  /// Where W passes from one polynomial (of degree four at most) to the next, 0 and 1 included.
  std::vector<double> knots() const;

 private:
  /// W on from..next.from, as a polynomial in s - from.
  struct Piece {
    double from;
    std::array<double, 5> coefficient;
  };
  const Piece& piece_at(double s) const;

  std::vector<Piece> piece_;
  double peak_ = 0.0;
};

}  // namespace backbend::solver
