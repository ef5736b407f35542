#include "solver/math/box_arc.h"

#include <algorithm>
#include <cmath>

namespace backbend::solver {

BoxArc::Coefficient BoxArc::coefficient(const BoxVector& v) {
  Coefficient c{v.value(), {v.x.center, v.y.center, v.z.center}, {}};
  for (std::size_t j = 0; j < kBoxVariables; ++j) c.slope[j] = v.slope(j);
  return c;
}

IntervalVector BoxArc::at(const IntervalVector& a, const IntervalVector& b, const IntervalVector& c,
                          const Interval& u) {
  return {a.x + u * (b.x + u * c.x), a.y + u * (b.y + u * c.y), a.z + u * (b.z + u * c.z)};
}

namespace {

/// p + (u - middle) (b + 2 u c): the mean value form of a + b u + c u^2, p its value at the middle.
Interval along(const Interval& p, const Interval& b, const Interval& c, const Interval& u,
               double middle) {
  return p + (u - Interval(middle)) * (b + Interval(2.0) * u * c);
}

}  // namespace

BoxArc::BoxArc(const std::array<BoxVector, 4>& cv, int panels)
    : BoxArc(std::array{cv[1] - cv[0], cv[2] - cv[1], cv[3] - cv[2]}, panels) {}

BoxArc::BoxArc(const std::array<BoxVector, 3>& legs, int panels) : panels_(panels) {
  const BoxReal three(3.0), six(6.0);
  const auto& [first, second, third] = legs;
  a_ = coefficient(three * first);
  b_ = coefficient(six * (second - first));
  c_ = coefficient(three * ((third - second) - (second - first)));
  until_.emplace_back(0.0);
  for (int i = 0; i < panels_; ++i) {
    panel_.push_back(piece(double(i) / panels_, double(i + 1) / panels_));
    until_.push_back(until_.back() + panel_.back());
  }
  length_ = until_.back();
  after_.assign(until_.size(), BoxReal(0.0));
  for (std::size_t i = after_.size() - 1; i-- > 0;) after_[i] = panel_[i] + after_[i + 1];
}

IntervalVector BoxArc::velocity(const Interval& u, double middle) const {
  const IntervalVector p = at(a_.value, b_.value, c_.value, middle);
  return {along(p.x, b_.value.x, c_.value.x, u, middle),
          along(p.y, b_.value.y, c_.value.y, u, middle),
          along(p.z, b_.value.z, c_.value.z, u, middle)};
}

Interval BoxArc::speed_slope(const Interval& u, const IntervalVector& velocity,
                             const Interval& speed, std::size_t j) const {
  return dot(velocity, at(a_.slope[j], b_.slope[j], c_.slope[j], u)) / speed;
}

BoxReal BoxArc::piece(double from, double to, int depth) const {
  const Interval u(from, to), h = Interval(to) - Interval(from);
  const double middle = 0.5 * (from + to);
  BoxReal r;
  {
    // At the box's middle, by the midpoint rule: h g(middle) + h^3 / 24 g'' somewhere on the piece.
    // The middle is one of doubles, so its distance from both ends is h / 2 for exact panels and
    // off by a rounding else, which the linear term covers.
    const IntervalVector p = at(a_.center, b_.center, c_.center, middle);
    const IntervalVector v{along(p.x, b_.center.x, c_.center.x, u, middle),
                           along(p.y, b_.center.y, c_.center.y, u, middle),
                           along(p.z, b_.center.z, c_.center.z, u, middle)};
    const Interval two(2.0);
    const IntervalVector second{b_.center.x + two * u * c_.center.x,
                                b_.center.y + two * u * c_.center.y,
                                b_.center.z + two * u * c_.center.z};
    const IntervalVector third{two * c_.center.x, two * c_.center.y, two * c_.center.z};
    const Interval speed = solver::length(v), slant = dot(v, second);
    constexpr int kDeepest = 6;
    if (!(speed.lo > 0.5 * speed.hi) && depth < kDeepest && speed.is_finite()) {
      return piece(from, middle, depth + 1) + piece(middle, to, depth + 1);
    }
    const Interval bend =
        (dot(second, second) + dot(v, third)) / speed - square(slant) / (speed * square(speed));
    const Interval off = Interval(0.5) * (Interval(from) + Interval(to)) - Interval(middle);
    r.center =
        h * solver::length(p) + h * off * (slant / speed) + h * square(h) / Interval(24.0) * bend;
  }
  const IntervalVector v = velocity(u, middle);
  const Interval speed = solver::length(v);
  double spread = 0.0;
  const Interval two(2.0), eighth = square(h) / Interval(8.0);
  const IntervalVector at_middle = velocity(middle, middle);
  const Interval speed_at_middle = solver::length(at_middle);
  const IntervalVector second{b_.value.x + two * u * c_.value.x, b_.value.y + two * u * c_.value.y,
                              b_.value.z + two * u * c_.value.z};
  const Interval slant = dot(v, second) / (speed * square(speed));
  for (std::size_t j = 0; j < kBoxVariables; ++j) {
    // h s(middle), and the integral of (u - middle) s'(..), whose factor has both signs alike: at
    // most h^2 / 8 of what s' varies over the piece. The middle's rounding is far below the rest.
    const Coefficient &a = a_, &b = b_, &c = c_;
    const IntervalVector d = at(a.slope[j], b.slope[j], c.slope[j], u);
    const IntervalVector d_slope{b.slope[j].x + two * u * c.slope[j].x,
                                 b.slope[j].y + two * u * c.slope[j].y,
                                 b.slope[j].z + two * u * c.slope[j].z};
    const Interval rate = (dot(second, d) + dot(v, d_slope)) / speed - dot(v, d) * slant;
    const double most = rounding::above_product(eighth.hi * rounding::above(rate.hi - rate.lo)) +
                        rounding::above_product(h.hi * (h.hi * 0x1p-50) * rate.most());
    r.slope[j] = h * speed_slope(middle, at_middle, speed_at_middle, j) + Interval(-most, most);
    if (!rate.is_finite()) r.slope[j] = Interval::entire();
    spread = rounding::above(spread + r.slope[j].most());
  }
  if (!r.center.is_finite() || !std::isfinite(spread)) return BoxReal::undefined();
  r.value = r.center + Interval(-spread, spread);
  return r;
}

BoxArc::Guess BoxArc::guess_at(double length) const {
  std::size_t panel = 0;
  while (int(panel) + 1 < panels_ && until_[panel + 1].center.middle() < length) ++panel;
  const double before = until_[panel].center.middle(), after = until_[panel + 1].center.middle();
  return {panel, (double(panel) + (length - before) / (after - before)) / panels_};
}

BoxReal BoxArc::parameter_at(const BoxReal& s) const {
  if (!length_.is_finite() || !s.is_finite()) return BoxReal::undefined();
  const auto [panel, guess] = guess_at(s.center.middle());
  const double from = double(panel) / panels_;
  if (!(guess > from - 1.0 && guess < from + 1.0)) return BoxReal::undefined();
  BoxReal reached = until_[panel];
  if (guess > from) reached = reached + piece(from, guess);
  if (guess < from) reached = reached - piece(guess, from);
  return root_near(guess, reached - s);
}

BoxReal BoxArc::parameter_at_share(double share, const BoxReal& before,
                                   const BoxReal& after) const {
  if (!length_.is_finite()) return BoxReal::undefined();
  const BoxReal of_after(share), of_before = BoxReal(1.0) - of_after;
  const double goal = share * (before + length_ + after).center.middle() - before.center.middle();
  const auto [panel, guess] = guess_at(goal);
  const double from = double(panel) / panels_, to = double(panel + 1) / panels_;
  if (!(guess > from - 1.0 && guess < to + 1.0)) return BoxReal::undefined();
  BoxReal until = before + until_[panel], rest = after_[panel + 1] + after;
  if (guess > from) until = until + piece(from, guess);
  if (guess < from) until = until - piece(guess, from);
  if (guess < to) rest = piece(guess, to) + rest;
  if (guess > to) rest = rest - piece(to, guess);
  // (1 - share) of what lies before less the share of what lies after: grows by one with the arc.
  return root_near(guess, of_before * until - of_after * rest);
}

BoxReal BoxArc::root_near(double guess, const BoxReal& error) const {
  if (!error.is_finite()) return BoxReal::undefined();
  // Interval Newton: if guess - error / speed(u) lies inside u, every pose of the box has its root
  // there. The speed is above 0, so it has no other.
  const Interval own(guess);
  double reach =
      1.5 * error.value.most() / std::max(1e-300, solver::length(velocity(own, guess)).lo) + 1e-13;
  for (int i = 0; i < 8; ++i, reach *= 1.6) {
    const Interval u = own + Interval(-reach, reach);
    const IntervalVector v = velocity(u, guess);
    const Interval speed = solver::length(v);
    if (!(speed.lo > 0.0)) return BoxReal::undefined();
    const Interval root = own - error.value / speed;
    if (!(root.lo > u.lo && root.hi < u.hi)) continue;
    BoxReal r;
    r.value = root;
    r.center = common(root, own - error.center / speed);
    for (std::size_t j = 0; j < kBoxVariables; ++j) {
      // By the implicit function theorem; the arc's slope is taken from the guess to the root.
      const Interval rest = (root - own) * speed_slope(hull(root, own), v, speed, j);
      r.slope[j] = -((error.slope[j] + rest) / speed);
    }
    return r;
  }
  return BoxReal::undefined();
}

}  // namespace backbend::solver
