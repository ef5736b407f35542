#pragma once
#include <optional>
#include <span>
#include <vector>

#include "solver/math/interval.h"

namespace backbend::validate {

/// Of a curve whose velocity at u is 3 (alpha X + beta c), with a fixed axis X of length 1 and a
/// unit vector c that poses turn: alpha and beta, and their first two derivatives by u. `knots` are
/// the u where they change from one quadratic to another; over a u that holds one, a derivative is
/// enclosed on both sides of it.
///
/// That of a spine between hips and chest: X from hips to chest at rest, c the chest's X axis.
class ChestShape {
  using Interval = solver::Interval;

 public:
  ChestShape(double hip_depth, double chest_depth) : hip_(hip_depth), chest_(chest_depth) {}

  Interval alpha(const Interval& u) const {
    const Interval s = Interval(1.0) - u;
    return hip_ * square(s) + Interval(2.0) * (Interval(1.0) - hip_) * u * s;
  }
  Interval beta(const Interval& u) const {
    return chest_ * u * (Interval(3.0) * u - Interval(2.0));
  }
  Interval alpha_slope(const Interval& u) const {
    return Interval(-2.0) * hip_ * (Interval(1.0) - u) +
           Interval(2.0) * (Interval(1.0) - hip_) * (Interval(1.0) - Interval(2.0) * u);
  }
  Interval beta_slope(const Interval& u) const {
    return chest_ * (Interval(6.0) * u - Interval(2.0));
  }
  Interval alpha_bend(const Interval&) const {
    return Interval(2.0) * hip_ - Interval(4.0) * (Interval(1.0) - hip_);
  }
  Interval beta_bend(const Interval&) const { return Interval(6.0) * chest_; }
  static std::span<const double> knots() { return {}; }

 private:
  Interval hip_, chest_;
};

/// Such a curve with kappa = X . c: the squared speed is 9 (alpha^2 + beta^2 + 2 alpha beta kappa),
/// so that the arc length depends on the pose by kappa alone.
template <class Shape>
class PlaneCurve {
  using Interval = solver::Interval;

 public:
  /// `panels`: lengths are enclosed on so many, the tighter the more.
  PlaneCurve(const Shape& shape, const Interval& kappa, int panels = 64)
      : shape_(shape), kappa_(kappa), middle_(kappa.middle()), panels_(panels) {
    until_.push_back({0.0, 0.0, 0.0});
    for (int i = 0; i < panels; ++i) {
      until_.push_back(sum_of(until_.back(), length(double(i) / panels, double(i + 1) / panels)));
    }
  }

  Interval alpha(const Interval& u) const { return shape_.alpha(u); }
  Interval beta(const Interval& u) const { return shape_.beta(u); }
  Interval alpha_slope(const Interval& u) const { return shape_.alpha_slope(u); }
  Interval beta_slope(const Interval& u) const { return shape_.beta_slope(u); }

  /// Three times the integrals of alpha and beta from u to v, that is the way between the two in
  /// units of X and c. By Simpson's rule, which is exact between knots.
  struct Way {
    Interval along_x, along_c;
  };
  Way way(const Interval& u, const Interval& v) const {
    const auto alpha = [&](const Interval& at) { return shape_.alpha(at); };
    const auto beta = [&](const Interval& at) { return shape_.beta(at); };
    return {integral(alpha, u, v), integral(beta, u, v)};
  }

  /// A length: over all kappas, at the middle one, and its derivative by kappa.
  struct Length {
    Interval value, center, slope;
  };
  const Length& whole() const { return until_.back(); }
  /// Cut finer where the speed varies much.
  Length length(double from, double to, int depth = 0) const {
    constexpr int kDeepest = 7;
    const Interval u(from, to), h = Interval(to) - Interval(from), two(2.0);
    const double m = 0.5 * (from + to);
    const Interval p = squared(u, middle_), root = square_root(p);
    const bool wide = to - from > 1.5 / panels_ || !(root.lo > 0.5 * root.hi);
    if (wide && depth < kDeepest) {
      return sum_of(length(from, m, depth + 1), length(m, to, depth + 1));
    }
    // Taylor's formula about m, which is the middle but for rounding: `off` takes that.
    const Interval p1 = squared_slope(u, middle_), p2 = squared_bend(u, middle_);
    const Interval bend = p2 / (two * root) - square(p1) / (Interval(4.0) * p * root);
    const Interval off = Interval(-1e-15, 1e-15);
    Length sum;
    sum.center =
        Interval(3.0) * (h * square_root(squared(m, middle_)) + h * off * p1 / (two * root) +
                         h * square(h) / Interval(24.0) * bend);
    const Interval q = squared(u, kappa_), q_root = square_root(q), both = alpha(u) * beta(u);
    const Interval change = (alpha_slope(u) * beta(u) + alpha(u) * beta_slope(u)) / q_root -
                            both * squared_slope(u, kappa_) / (two * q * q_root);
    const Interval vary =
        square(h) / Interval(8.0) * (Interval(change.hi) - Interval(change.lo)) + h * off * change;
    sum.slope = Interval(3.0) * (h * alpha(m) * beta(m) / square_root(squared(m, kappa_)) +
                                 Interval(-vary.most(), vary.most()));
    sum.value = sum.center + sum.slope * (kappa_ - Interval(middle_));
    return sum;
  }

  Interval speed(const Interval& u) const {
    return Interval(3.0) * square_root(squared(u, kappa_));
  }
  /// d speed / d kappa.
  Interval speed_slope(const Interval& u) const {
    return Interval(9.0) * alpha(u) * beta(u) / speed(u);
  }

  /// The parameter at a length, over all kappas, and its derivative by kappa.
  struct Place {
    Interval u, slope;
  };
  std::optional<Place> at(const Length& goal) const {
    const double wanted = goal.center.middle();
    std::size_t panel = 0;
    while (panel + 2 < until_.size() && until_[panel + 1].center.middle() < wanted) ++panel;
    const double start = double(panel) / panels_, before = until_[panel].center.middle();
    const double share = (wanted - before) / (until_[panel + 1].center.middle() - before);
    if (!(share >= 0.0 && share < panels_)) return std::nullopt;
    const double guess = start + share / panels_;
    const Length there = sum_of(until_[panel], length(start, guess));
    const Interval miss =
        there.center - goal.center + (there.slope - goal.slope) * (kappa_ - Interval(middle_));
    const Interval now = speed(guess);
    if (!(now.lo > 0.0) || !miss.is_finite()) return std::nullopt;
    double reach = 1.3 * miss.most() / now.lo + 1e-12;
    for (int i = 0; i < 6; ++i, reach *= 2.0) {
      const Interval u = Interval(guess) + Interval(-reach, reach), fast = speed(u);
      if (!(fast.lo > 0.0)) return std::nullopt;
      const Interval root = Interval(guess) - miss / fast;
      if (!(root.lo > u.lo && root.hi < u.hi)) continue;
      const Interval slope = there.slope + (root - Interval(guess)) * speed_slope(u) - goal.slope;
      return Place{root, -slope / fast};
    }
    return std::nullopt;
  }

 private:
  static Length sum_of(const Length& a, const Length& b) {
    return {a.value + b.value, a.center + b.center, a.slope + b.slope};
  }
  template <class Function>
  Interval integral(const Function& f, const Interval& u, const Interval& v) const {
    Interval sum(0.0), from = u;
    const auto add = [&](const Interval& to) {
      const Interval step = to - from;
      // Where the two may be one, or in either order, by the mean.
      sum = sum + (to.lo > from.hi
                       ? step / Interval(6.0) *
                             (f(from) + Interval(4.0) * f(Interval(0.5) * (from + to)) + f(to))
                       : step * f(hull(from, to)));
      from = to;
    };
    for (const double knot : shape_.knots())
      if (knot > u.lo && knot < v.hi) add(knot);
    add(v);
    return Interval(3.0) * sum;
  }

  /// alpha^2 + beta^2 + 2 alpha beta kappa, as squares: nothing cancels.
  Interval squared(const Interval& u, const Interval& kappa) const {
    const Interval a = alpha(u), b = beta(u);
    return square(a + b * kappa) + square(b) * (Interval(1.0) - square(kappa));
  }
  Interval squared_slope(const Interval& u, const Interval& kappa) const {
    const Interval a = alpha(u), b = beta(u), a1 = alpha_slope(u), b1 = beta_slope(u);
    return Interval(2.0) * (a * a1 + b * b1 + kappa * (a1 * b + a * b1));
  }
  Interval squared_bend(const Interval& u, const Interval& kappa) const {
    const Interval a = alpha(u), b = beta(u), a1 = alpha_slope(u), b1 = beta_slope(u);
    const Interval a2 = shape_.alpha_bend(u), b2 = shape_.beta_bend(u), two(2.0);
    return two *
           (square(a1) + a * a2 + square(b1) + b * b2 + kappa * (a2 * b + two * a1 * b1 + a * b2));
  }

  Shape shape_;
  Interval kappa_;
  double middle_;
  int panels_;
  std::vector<Length> until_;  // lengths up to each panel's end
};

using ChestCurve = PlaneCurve<ChestShape>;

}  // namespace backbend::validate
