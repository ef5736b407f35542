#pragma once
#include <algorithm>
#include <cmath>
#include <limits>

/// Outward-rounded interval arithmetic: what proofs over whole boxes of poses rest on.
///
/// An operation's result encloses the exact result for every choice of numbers from its operands.
/// The processor stays in its usual rounding mode: a bound is moved outward by one to two units in
/// the last place after each operation, which is never off by more than half of one.
///
/// What is not defined somewhere on its operand (a division by an interval that holds 0) gives
/// Interval::entire(), and so does what overflows; whatever is calculated from it is not finite
/// either. So a finite result is proof that no step of its calculation was undefined.
namespace backbend::solver {

struct Interval {
  double lo = 0.0, hi = 0.0;

  constexpr Interval() = default;
  constexpr Interval(double exactly) : lo(exactly), hi(exactly) {}  // NOLINT: constants read better
  constexpr Interval(double low, double high) : lo(low), hi(high) {}

  static constexpr Interval entire() {
    return {-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  }

  bool is_finite() const {
    return lo >= -std::numeric_limits<double>::max() && hi <= std::numeric_limits<double>::max();
  }
  bool holds(double x) const { return lo <= x && x <= hi; }
  bool is_zero() const { return lo == 0.0 && hi == 0.0; }
  double width() const { return hi - lo; }
  double middle() const { return 0.5 * lo + 0.5 * hi; }
  /// The largest absolute value.
  double most() const { return std::max(std::abs(lo), std::abs(hi)); }
};

namespace rounding {

/// Below every number that rounds to `r` in one operation, unless it was lost to underflow. The
/// error is at most half a unit in the last place, |r| 2^-52 is one to two units, and taking it
/// away is off by another half of one.
inline double below(double r) { return r - std::abs(r) * 0x1p-52; }
inline double above(double r) { return r + std::abs(r) * 0x1p-52; }

/// The same where the operation may have underflowed (products, quotients): by less than 2^-1074.
inline double below_product(double r) { return below(r) - 0x1p-1022; }
inline double above_product(double r) { return above(r) + 0x1p-1022; }

/// For functions of the C library. The library's manual says that those used here are off by at
/// most 1 unit in the last place (Debian 12 and 13; sine and cosine measured below 0.6); four to
/// eight units are taken. tests/solver/math/interval_test.cpp tries them against MPFI.
inline double below_function(double r) { return r - (std::abs(r) * 0x1p-50 + 0x1p-1022); }
inline double above_function(double r) { return r + (std::abs(r) * 0x1p-50 + 0x1p-1022); }

inline Interval checked(double lo, double hi) {
  const Interval r(lo, hi);
  return r.is_finite() ? r : Interval::entire();
}

}  // namespace rounding

inline Interval operator-(const Interval& a) { return {-a.hi, -a.lo}; }

inline Interval operator+(const Interval& a, const Interval& b) {
  return rounding::checked(rounding::below(a.lo + b.lo), rounding::above(a.hi + b.hi));
}
inline Interval operator-(const Interval& a, const Interval& b) {
  return rounding::checked(rounding::below(a.lo - b.hi), rounding::above(a.hi - b.lo));
}
inline Interval operator*(const Interval& a, const Interval& b) {
  if (!a.is_finite() || !b.is_finite()) return Interval::entire();
  if (a.is_zero() || b.is_zero()) return 0.0;
  const double p = a.lo * b.lo, q = a.lo * b.hi, r = a.hi * b.lo, s = a.hi * b.hi;
  return rounding::checked(rounding::below_product(std::min(std::min(p, q), std::min(r, s))),
                           rounding::above_product(std::max(std::max(p, q), std::max(r, s))));
}
inline Interval operator/(const Interval& a, const Interval& b) {
  if (!a.is_finite() || !b.is_finite() || (b.lo <= 0.0 && b.hi >= 0.0)) return Interval::entire();
  const double p = a.lo / b.lo, q = a.lo / b.hi, r = a.hi / b.lo, s = a.hi / b.hi;
  return rounding::checked(rounding::below_product(std::min(std::min(p, q), std::min(r, s))),
                           rounding::above_product(std::max(std::max(p, q), std::max(r, s))));
}
inline Interval& operator+=(Interval& a, const Interval& b) { return a = a + b; }

inline Interval square(const Interval& a) {
  if (!a.is_finite()) return Interval::entire();
  const double low = std::abs(a.lo), high = std::abs(a.hi);
  const double most = std::max(low, high), least = a.holds(0.0) ? 0.0 : std::min(low, high);
  return rounding::checked(std::max(0.0, rounding::below_product(least * least)),
                           rounding::above_product(most * most));
}

/// The root of the part that is not negative. For sums of squares, whose bound may be rounded below
/// 0; entire() where nothing of `a` is at or above 0.
inline Interval square_root(const Interval& a) {
  if (!a.is_finite() || a.hi < 0.0) return Interval::entire();
  return {std::max(0.0, rounding::below(std::sqrt(std::max(0.0, a.lo)))),
          rounding::above(std::sqrt(a.hi))};
}

inline Interval absolute(const Interval& a) {
  if (a.lo >= 0.0) return a;
  if (a.hi <= 0.0) return -a;
  return {0.0, a.most()};
}
inline Interval smaller(const Interval& a, const Interval& b) {
  return {std::min(a.lo, b.lo), std::min(a.hi, b.hi)};
}
/// The smallest interval that holds both.
inline Interval hull(const Interval& a, const Interval& b) {
  return {std::min(a.lo, b.lo), std::max(a.hi, b.hi)};
}
/// What two enclosures of one number have in common. They overlap, or one of them is wrong: then
/// entire(), which proves nothing.
inline Interval common(const Interval& a, const Interval& b) {
  const Interval r(std::max(a.lo, b.lo), std::min(a.hi, b.hi));
  return r.lo <= r.hi ? r : Interval::entire();
}

/// pi, between two neighbouring doubles.
inline constexpr Interval kPiInterval{0x1.921fb54442d18p+1, 0x1.921fb54442d19p+1};

namespace rounding {

/// The largest angle whose quadrant is worked out; sines of larger ones are anything in [-1, 1].
inline constexpr double kMostAngle = 1e6;

/// Sine or cosine over `a` from its values at both ends; extrema stand at (k + shift) pi, k even
/// for a maximum.
template <class Function>
Interval wave(const Interval& a, double shift, Function of) {
  if (!(a.lo >= -kMostAngle && a.hi <= kMostAngle)) return {-1.0, 1.0};
  const Interval halves = a / kPiInterval - shift;
  const double first = std::ceil(halves.lo), last = std::floor(halves.hi);
  double low = below_function(std::min(of(a.lo), of(a.hi)));
  double high = above_function(std::max(of(a.lo), of(a.hi)));
  if (last >= first) {
    const bool even = std::fmod(first, 2.0) == 0.0;
    if (even || last > first) high = 1.0;
    if (!even || last > first) low = -1.0;
  }
  return {std::max(low, -1.0), std::min(high, 1.0)};
}

}  // namespace rounding

inline Interval sine(const Interval& a) {
  if (a.is_zero()) return 0.0;
  return rounding::wave(a, 0.5, [](double x) { return std::sin(x); });
}
inline Interval cosine(const Interval& a) {
  if (a.is_zero()) return 1.0;
  return rounding::wave(a, 0.0, [](double x) { return std::cos(x); });
}

/// The angle whose cosine is in the part of `a` inside [-1, 1]; entire() where there is none.
inline Interval arc_cosine(const Interval& a) {
  if (!(a.lo <= 1.0 && a.hi >= -1.0)) return Interval::entire();
  return {std::max(0.0, rounding::below_function(std::acos(std::min(1.0, a.hi)))),
          rounding::above_function(std::acos(std::max(-1.0, a.lo)))};
}
inline Interval arc_sine(const Interval& a) {
  if (!(a.lo <= 1.0 && a.hi >= -1.0)) return Interval::entire();
  return {rounding::below_function(std::asin(std::max(-1.0, a.lo))),
          rounding::above_function(std::asin(std::min(1.0, a.hi)))};
}
/// The angle of the points (x, y). [-pi, pi] where the box of them meets the cut along the negative
/// x axis, or holds the origin.
inline Interval arc_tangent(const Interval& y, const Interval& x) {
  if (!x.is_finite() || !y.is_finite()) return Interval::entire();
  if (x.lo <= 0.0 && y.lo <= 0.0 && y.hi >= 0.0) return {-kPiInterval.hi, kPiInterval.hi};
  // Without the origin inside, the angle has no extremum but at a corner.
  const double p = std::atan2(y.lo, x.lo), q = std::atan2(y.lo, x.hi), r = std::atan2(y.hi, x.lo),
               s = std::atan2(y.hi, x.hi);
  return {rounding::below_function(std::min(std::min(p, q), std::min(r, s))),
          rounding::above_function(std::max(std::max(p, q), std::max(r, s)))};
}

}  // namespace backbend::solver
