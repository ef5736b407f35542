#include "solver/math/box_number.h"

#include <cassert>
#include <limits>

#include "solver/math/rotation.h"

namespace backbend::solver {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();

double sum_above(double a, double b) { return rounding::above(a + b); }
double product_above(double a, double b) {
  return a == 0.0 || b == 0.0 ? 0.0 : rounding::above_product(a * b);
}

/// f(a) from its value, its value at the middle and its derivative over the box.
BoxReal chained(const Interval& value, const Interval& center, const Interval& derivative,
                const BoxReal& a) {
  BoxReal r;
  r.value = value;
  r.center = center;
  for (int j = 0; j < kBoxVariables; ++j) {
    // A number that a variable does not move stays unmoved by it, whatever the derivative.
    if (!a.slope[j].is_zero()) r.slope[j] = derivative * a.slope[j];
  }
  return narrowed(r);
}

BoxReal weighted(double m0, const BoxReal& a, double m1, const BoxReal& b, double m2,
                 const BoxReal& c) {
  return BoxReal(m0) * a + BoxReal(m1) * b + BoxReal(m2) * c;
}

/// Of z = (1 - c) / 2, below 0.01: sin(t h) / sin(h) = t F(1 + t, 1 - t; 3/2; z), the
/// hypergeometric series, whose terms are all positive and fall at least by `ratio`; `order` 1 is
/// its derivative by z. (The differential equation of sin(t h) / sin(h) in c is Gauss's.)
Interval weight_series(const Interval& z, double t, int order) {
  constexpr int kTerms = 12;
  const Interval own(t);
  Interval term = own;
  if (order == 1) term = own * (Interval(1.0) + own) * (Interval(1.0) - own) / Interval(1.5);
  Interval sum = term;
  for (int n = 0; n < kTerms; ++n) {
    const double k = n + order;  // the parameters of a derivative are one higher
    const Interval above = square(Interval(1.0 + k)) - square(own);
    term = term * z * above / (Interval(1.5 + k) * Interval(n + 1.0));
    sum = sum + term;
  }
  // The ratio of terms is below (k + 1)^2 / ((k + 1.5) (n + 1)) z < 2 z < 0.02 from here on.
  return sum + Interval(0.0, 0.05) * Interval(0.0, std::max(0.0, term.hi));
}

Interval weight_at(double c, double t) {
  if (c > 0.98) return weight_series(Interval(0.5) * (Interval(1.0) - Interval(c)), t, 0);
  const Interval h = arc_cosine(c);
  return sine(Interval(t) * h) / sine(h);
}

Interval weight_slope_at(double c, double t) {
  // d/dc = -1/2 d/dz
  if (c > 0.98) {
    return Interval(-0.5) * weight_series(Interval(0.5) * (Interval(1.0) - Interval(c)), t, 1);
  }
  const Interval h = arc_cosine(c);
  const Interval weight = sine(Interval(t) * h) / sine(h);
  return (weight * Interval(c) - Interval(t) * cosine(Interval(t) * h)) /
         (Interval(1.0) - square(Interval(c)));
}

/// Of an arc h, with p = sin^2(h / 2): h / sin(h), as a power series with positive terms, of which
/// each is less than p times the one before. `order` 1 is its derivative by p.
Interval arc_over_sine_series(double p, int order) {
  constexpr int kTerms = 30;
  Interval term(1.0), sum(order == 0 ? 1.0 : 0.0);
  for (int n = 1; n < kTerms; ++n) {
    term = term * Interval(2.0 * n) / Interval(2.0 * n + 1.0);
    if (order == 1) sum += Interval(n) * term;
    term = term * Interval(p);
    if (order == 0) sum += term;
  }
  // Of the derivative's the ratio is below p (n + 1) / n.
  const Interval rest = Interval(2.0 * kTerms) * term;
  return sum + Interval(0.0, std::max(0.0, rest.hi));
}

constexpr double kMostSeries = 0.25;  // where the rest of the series is below 1e-15

Interval arc_over_sine_at(double p) {
  if (p <= kMostSeries) return arc_over_sine_series(p, 0);
  const Interval own(p);
  return arc_sine(square_root(own)) / square_root(own * (Interval(1.0) - own));
}

/// By 2 p (1 - p) f' + (1 - 2 p) f = 1.
Interval arc_over_sine_slope_at(double p) {
  if (p <= kMostSeries) return arc_over_sine_series(p, 1);
  const Interval own(p), twice = Interval(2.0) * own;
  return (Interval(1.0) - (Interval(1.0) - twice) * arc_over_sine_at(p)) /
         (twice * (Interval(1.0) - own));
}

BoxReal weight_of(const BoxReal& c, double t) {
  return chained(slerp_weight(c.value, t), slerp_weight(c.center, t),
                 slerp_weight_slope(c.value, t), c);
}

}  // namespace

BoxReal narrowed(BoxReal r) {
  if (!r.value.is_finite()) return BoxReal::undefined();
  double spread = 0.0;
  for (const Interval& s : r.slope) {
    if (!s.is_finite()) return r;
    spread = sum_above(spread, s.most());
  }
  r.value = common(r.value, r.center + Interval(-spread, spread));
  return r;
}

BoxReal BoxReal::variable(int j, double low, double high) {
  BoxReal r;
  r.value = {low, high};
  const double middle = r.value.middle();
  r.center = middle;
  const Interval both = hull(Interval(high) - Interval(middle), Interval(middle) - Interval(low));
  r.slope[std::size_t(j)] = both.hi;
  return r;
}

BoxReal BoxReal::undefined() {
  BoxReal r(Interval::entire());
  r.slope.fill(Interval::entire());
  return r;
}

BoxVector BoxVector::undefined() {
  const BoxReal any = BoxReal::undefined();
  return {any, any, any};
}

BoxTurn BoxTurn::undefined() {
  const BoxReal any = BoxReal::undefined();
  return {any, any, any, any, {kInfinite, kInfinite, kInfinite}};
}

bool BoxReal::is_finite() const {
  for (const Interval& s : slope)
    if (!s.is_finite()) return false;
  return value.is_finite() && center.is_finite();
}

BoxReal operator-(const BoxReal& a) {
  BoxReal r;
  r.value = -a.value;
  r.center = -a.center;
  for (int j = 0; j < kBoxVariables; ++j) r.slope[j] = -a.slope[j];
  return r;
}

BoxReal operator+(const BoxReal& a, const BoxReal& b) {
  BoxReal r;
  r.value = a.value + b.value;
  r.center = a.center + b.center;
  for (int j = 0; j < kBoxVariables; ++j) r.slope[j] = a.slope[j] + b.slope[j];
  return narrowed(r);
}

BoxReal operator-(const BoxReal& a, const BoxReal& b) { return a + (-b); }

BoxReal operator*(const BoxReal& a, const BoxReal& b) {
  BoxReal r;
  r.value = a.value * b.value;
  r.center = a.center * b.center;
  for (int j = 0; j < kBoxVariables; ++j) {
    if (!a.slope[j].is_zero()) r.slope[j] = a.slope[j] * b.value;
    if (!b.slope[j].is_zero()) r.slope[j] += a.value * b.slope[j];
  }
  return narrowed(r);
}

BoxReal operator/(const BoxReal& a, const BoxReal& b) {
  BoxReal r;
  r.value = a.value / b.value;
  r.center = a.center / b.center;
  for (int j = 0; j < kBoxVariables; ++j) {
    if (a.slope[j].is_zero() && b.slope[j].is_zero()) continue;
    r.slope[j] = (a.slope[j] - r.value * b.slope[j]) / b.value;
  }
  return narrowed(r);
}

BoxReal square(const BoxReal& a) {
  return chained(square(a.value), square(a.center), Interval(2.0) * a.value, a);
}

BoxReal square_root(const BoxReal& a) {
  const Interval root = square_root(a.value);
  return chained(root, square_root(a.center), Interval(0.5) / root, a);
}

BoxReal sine(const BoxReal& a) {
  return chained(sine(a.value), sine(a.center), cosine(a.value), a);
}

BoxReal cosine(const BoxReal& a) {
  return chained(cosine(a.value), cosine(a.center), -sine(a.value), a);
}

BoxReal smaller(const BoxReal& a, const BoxReal& b) {
  if (a.value.hi < b.value.lo) return a;
  if (b.value.hi < a.value.lo) return b;
  BoxReal r;
  r.value = smaller(a.value, b.value);
  r.center = smaller(a.center, b.center);
  for (int j = 0; j < kBoxVariables; ++j) r.slope[j] = hull(a.slope[j], b.slope[j]);
  return narrowed(r);
}

BoxReal larger(const BoxReal& a, const BoxReal& b) { return -smaller(-a, -b); }

BoxReal hull(const BoxReal& a, const BoxReal& b) {
  BoxReal r;
  r.value = hull(a.value, b.value);
  r.center = hull(a.center, b.center);
  for (std::size_t j = 0; j < kBoxVariables; ++j) r.slope[j] = hull(a.slope[j], b.slope[j]);
  return r;
}

IntervalVector operator+(const IntervalVector& a, const IntervalVector& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
IntervalVector operator-(const IntervalVector& a, const IntervalVector& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
IntervalVector operator*(const Interval& f, const IntervalVector& v) {
  return {f * v.x, f * v.y, f * v.z};
}
Interval dot(const IntervalVector& a, const IntervalVector& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
IntervalVector cross(const IntervalVector& a, const IntervalVector& b) {
  return {a.y * b.z - b.y * a.z, a.z * b.x - b.z * a.x, a.x * b.y - b.x * a.y};
}
Interval length(const IntervalVector& v) {
  return square_root(square(v.x) + square(v.y) + square(v.z));
}

BoxVector operator-(const BoxVector& a) { return {-a.x, -a.y, -a.z}; }
BoxVector operator+(const BoxVector& a, const BoxVector& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
BoxVector operator-(const BoxVector& a, const BoxVector& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
BoxVector operator*(const BoxReal& f, const BoxVector& v) { return {f * v.x, f * v.y, f * v.z}; }
BoxVector operator/(const BoxVector& v, const BoxReal& f) { return {v.x / f, v.y / f, v.z / f}; }
BoxVector operator*(const glm::dmat3& m, const BoxVector& v) {
  return {weighted(m[0][0], v.x, m[1][0], v.y, m[2][0], v.z),
          weighted(m[0][1], v.x, m[1][1], v.y, m[2][1], v.z),
          weighted(m[0][2], v.x, m[1][2], v.y, m[2][2], v.z)};
}

BoxReal dot(const BoxVector& a, const BoxVector& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
BoxReal length(const BoxVector& v) { return square_root(square(v.x) + square(v.y) + square(v.z)); }
/// 1 - x x as y y + z z, which does not lose what it is small by.
IntervalVector across(const IntervalVector& u, const IntervalVector& v) {
  const Interval xx = square(u.x), yy = square(u.y), zz = square(u.z);
  const Interval xy = u.x * u.y, yz = u.y * u.z, zx = u.z * u.x;
  return {(yy + zz) * v.x - xy * v.y - zx * v.z, (zz + xx) * v.y - yz * v.z - xy * v.x,
          (xx + yy) * v.z - zx * v.x - yz * v.y};
}

BoxVector unit(const BoxVector& v) {
  const BoxReal size = length(v);
  BoxVector u = v / size;
  for (std::size_t j = 0; j < kBoxVariables; ++j) {
    const IntervalVector turned = across(u.value(), v.slope(j));
    u.x.slope[j] = common(u.x.slope[j], turned.x / size.value);
    u.y.slope[j] = common(u.y.slope[j], turned.y / size.value);
    u.z.slope[j] = common(u.z.slope[j], turned.z / size.value);
  }
  return {narrowed(u.x), narrowed(u.y), narrowed(u.z)};
}

BoxVector cross(const BoxVector& a, const BoxVector& b) {
  return {a.y * b.z - b.y * a.z, a.z * b.x - b.z * a.x, a.x * b.y - b.x * a.y};
}

BoxVector hull(const BoxVector& a, const BoxVector& b) {
  return {hull(a.x, b.x), hull(a.y, b.y), hull(a.z, b.z)};
}

BoxVector arc_between(const BoxVector& from, const BoxVector& to) {
  constexpr double kMost = 0.85;  // of p; the series' terms stay positive to 1
  const BoxVector chord = to - from;
  const BoxReal p = BoxReal(0.25) * (square(chord.x) + square(chord.y) + square(chord.z));
  const auto between = [](const Interval& at, auto f) {
    return Interval(f(std::max(0.0, at.lo)).lo, f(at.hi).hi);
  };
  if (!p.is_finite() || !(p.value.hi < kMost) || !(p.center.hi < kMost))
    return BoxVector::undefined();
  const BoxReal longer =
      chained(between(p.value, arc_over_sine_at), between(p.center, arc_over_sine_at),
              between(p.value, arc_over_sine_slope_at), p);
  return longer * cross(from, chord);
}

BoxTurn with_least_rates(BoxTurn q) {
  if (!q.w.value.is_finite() || !q.x.value.is_finite() || !q.y.value.is_finite() ||
      !q.z.value.is_finite()) {
    q.rate.fill(kInfinite);
    return q;
  }
  for (int j = 0; j < kBoxVariables; ++j) {
    const Interval sum =
        square(q.w.slope[j]) + square(q.x.slope[j]) + square(q.y.slope[j]) + square(q.z.slope[j]);
    if (!sum.is_finite()) continue;
    q.rate[j] = std::min(q.rate[j], (Interval(2.0) * square_root(sum)).hi);
  }
  return q;
}

BoxTurn operator*(const BoxTurn& p, const BoxTurn& q) {
  BoxRates rate;
  for (int j = 0; j < kBoxVariables; ++j) rate[j] = sum_above(p.rate[j], q.rate[j]);
  return with_least_rates({p.w * q.w - p.x * q.x - p.y * q.y - p.z * q.z,
                           p.w * q.x + p.x * q.w + p.y * q.z - p.z * q.y,
                           p.w * q.y + p.y * q.w + p.z * q.x - p.x * q.z,
                           p.w * q.z + p.z * q.w + p.x * q.y - p.y * q.x, rate});
}

BoxTurn conjugate(const BoxTurn& q) { return {q.w, -q.x, -q.y, -q.z, q.rate}; }

BoxVector operator*(const BoxTurn& q, const BoxVector& v) {
  const BoxVector u(q.x, q.y, q.z);
  const BoxVector once = cross(u, v);
  return v + BoxReal(2.0) * (q.w * once + cross(u, once));
}

BoxTurn turn_about(const glm::dvec3& axis, const BoxReal& angle) {
  const BoxReal half = BoxReal(0.5) * angle;
  const BoxReal s = sine(half);
  BoxRates rate;
  for (int j = 0; j < kBoxVariables; ++j) rate[j] = angle.slope[j].most();
  return {cosine(half), BoxReal(axis.x) * s, BoxReal(axis.y) * s, BoxReal(axis.z) * s, rate};
}

BoxTurn from_euler_xyz(const BoxReal& rx, const BoxReal& ry, const BoxReal& rz) {
  return turn_about(kAxisZ, rz) * turn_about(kAxisY, ry) * turn_about(kAxisX, rx);
}

BoxTurn euler_turn(const glm::dmat3& axes, const BoxTurn& euler) {
  const BoxVector v = axes * BoxVector(euler.x, euler.y, euler.z);
  return {euler.w, v.x, v.y, v.z, euler.rate};
}

/// By the trace, which is 4 w^2 - 1.
BoxTurn turn_to_axes(const BoxVector& x, const BoxVector& y, const BoxVector& z) {
  const BoxReal w = BoxReal(0.5) * square_root(BoxReal(1.0) + x.x + y.y + z.z);
  if (!(w.value.lo > 0.0)) return BoxTurn::undefined();
  const BoxReal scale = BoxReal(0.25) / w;
  return with_least_rates({w,
                           scale * (y.z - z.y),
                           scale * (z.x - x.z),
                           scale * (x.y - y.x),
                           {kInfinite, kInfinite, kInfinite}});
}

Interval slerp_weight(const Interval& c, double t) {
  assert(0.0 <= t && t <= 1.0);
  if (!(c.lo > 0.0) || !c.is_finite()) return Interval::entire();
  return {weight_at(std::min(1.0, c.hi), t).lo, weight_at(std::min(1.0, c.lo), t).hi};
}

/// The series in z has positive terms, so its derivative grows with z: -d/dc is largest at c.lo.
Interval slerp_weight_slope(const Interval& c, double t) {
  if (!(c.lo > 0.0) || !c.is_finite()) return Interval::entire();
  return {weight_slope_at(std::min(1.0, c.lo), t).lo, weight_slope_at(std::min(1.0, c.hi), t).hi};
}

BoxTurn slerp_short(const BoxTurn& a, const BoxTurn& b, double t) {
  BoxReal c = a.w * b.w + a.x * b.x + a.y * b.y + a.z * b.z;
  double sign = 1.0;
  if (c.value.hi < 0.0) {
    sign = -1.0;
    c = -c;
  }
  if (!(c.value.lo > 0.0)) return BoxTurn::undefined();
  const BoxReal of_a = weight_of(c, 1.0 - t), of_b = BoxReal(sign) * weight_of(c, t);
  // With h half the angle between a and b: turning one end by d turns the result by its share of d
  // about the common axis, and by sin(t h) / sin(h) of d, which is at least that, about axes
  // perpendicular to it.
  const double share_a = slerp_weight(c.value, 1.0 - t).hi, share_b = slerp_weight(c.value, t).hi;
  BoxRates rate;
  for (int j = 0; j < kBoxVariables; ++j) {
    rate[j] = sum_above(product_above(share_a, a.rate[j]), product_above(share_b, b.rate[j]));
  }
  return with_least_rates({of_a * a.w + of_b * b.w, of_a * a.x + of_b * b.x,
                           of_a * a.y + of_b * b.y, of_a * a.z + of_b * b.z, rate});
}

BoxTurn shortest_arc(const BoxVector& from, const BoxVector& to, const BoxVector&) {
  const BoxVector sum = from + to;
  const BoxReal size = length(sum);
  if (!(size.value.lo > 0.0)) return BoxTurn::undefined();
  const BoxVector bisector = (BoxReal(1.0) / size) * sum;
  const BoxVector v = cross(from, bisector);
  return with_least_rates({dot(from, bisector), v.x, v.y, v.z, {kInfinite, kInfinite, kInfinite}});
}

BoxRates rates_of_aim(const BoxVector& velocity, const BoxVector& up) {
  BoxRates rate;
  rate.fill(kInfinite);
  const BoxReal speed = length(velocity);
  const BoxVector x = velocity / speed, side = cross(x, up);
  const BoxReal sine = length(side);
  const BoxVector z = side / sine, y = cross(z, x);
  const Interval lean = dot(up, x).value;
  if (!z.is_finite() || !y.is_finite() || !up.is_finite() || !lean.is_finite()) return rate;
  const auto along = [](const BoxVector& axis, const BoxVector& moved, std::size_t j) {
    return axis.x.value * moved.x.slope[j] + axis.y.value * moved.y.slope[j] +
           axis.z.value * moved.z.slope[j];
  };
  for (std::size_t j = 0; j < kBoxVariables; ++j) {
    const Interval across_z = along(z, velocity, j) / speed.value;
    const Interval across_y = along(y, velocity, j) / speed.value;
    const Interval about = (lean * across_z - along(z, up, j)) / sine.value;
    const Interval sum = square(across_z) + square(across_y) + square(about);
    if (sum.is_finite()) rate[j] = square_root(sum).hi;
  }
  return rate;
}

namespace {

/// `axis`: from x to.
BoxSlopes roll_about(const IntervalVector& axis, const BoxVector& from, const BoxVector& to) {
  BoxSlopes roll;
  roll.fill(Interval::entire());
  const Interval one_and_cosine = Interval(1.0) + dot(from, to).value;
  if (!(one_and_cosine.lo > 0.0)) return roll;
  for (std::size_t j = 0; j < kBoxVariables; ++j)
    roll[j] = -(dot(axis, from.slope(j) + to.slope(j)) / one_and_cosine);
  return roll;
}

}  // namespace

BoxSlopes roll_of_arc(const BoxVector& from, const BoxVector& to) {
  return roll_about(cross(from, to).value(), from, to);
}

BoxSlopes roll_of_arc(const BoxVector& from, const BoxVector& to, const IntervalVector& turned) {
  return roll_about(cross(from.value(), turned), from, to);
}

}  // namespace backbend::solver
