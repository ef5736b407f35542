#pragma once
#include <array>
#include <cstddef>
#include <glm/vec3.hpp>

#include "solver/math/interval.h"

/// Numbers and vectors over a part of a box of poses, for checkers: small, and apart from the
/// search's own (solver/math/box_number.h).
namespace backbend::validate {

using Vec = std::array<solver::Interval, 3>;

inline Vec operator+(const Vec& a, const Vec& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
inline Vec operator-(const Vec& a, const Vec& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
inline Vec operator*(const solver::Interval& f, const Vec& v) {
  return {f * v[0], f * v[1], f * v[2]};
}
inline solver::Interval dot(const Vec& a, const Vec& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
inline Vec cross(const Vec& a, const Vec& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline solver::Interval size_squared(const Vec& a) {
  return square(a[0]) + square(a[1]) + square(a[2]);
}
inline solver::Interval size(const Vec& a) { return square_root(size_squared(a)); }
/// Of length 1, for a vector nearly along the first axis: how much of it lies along that axis is
/// taken from the other two, too, because only its length is uncertain there.
inline Vec unit(const Vec& v) {
  Vec out = solver::Interval(1.0) / size(v) * v;
  if (v[0].lo > 0.0) {
    const solver::Interval rest = square(out[1]) + square(out[2]);
    out[0] = common(out[0], square_root(solver::Interval(1.0) - rest));
  }
  return out;
}
inline glm::dvec3 middle_of(const Vec& v) { return {v[0].middle(), v[1].middle(), v[2].middle()}; }
inline Vec hull(const Vec& a, const Vec& b) {
  return {hull(a[0], b[0]), hull(a[1], b[1]), hull(a[2], b[2])};
}

/// How far each channel goes from its middle over the part, radians.
using Reach = std::array<solver::Interval, 3>;

/// A number or a vector: its value over all poses of a part and at the part's middle, and its
/// derivatives by the three channels over all poses.
template <class Of>
struct Moving {
  Of value{}, center{};
  std::array<Of, 3> by{};

  Moving() = default;
  Moving(const Of& fixed) : value(fixed), center(fixed) {}  // NOLINT: fixed ones are many
  Moving(const Of& over, const Of& at_middle, const std::array<Of, 3>& slope)
      : value(over), center(at_middle), by(slope) {}
};
using MovingNumber = Moving<solver::Interval>;
using MovingVector = Moving<Vec>;

template <class Of>
Moving<Of> operator+(const Moving<Of>& a, const Moving<Of>& b) {
  return {a.value + b.value,
          a.center + b.center,
          {a.by[0] + b.by[0], a.by[1] + b.by[1], a.by[2] + b.by[2]}};
}
template <class Of>
Moving<Of> operator-(const Moving<Of>& a, const Moving<Of>& b) {
  return {a.value - b.value,
          a.center - b.center,
          {a.by[0] - b.by[0], a.by[1] - b.by[1], a.by[2] - b.by[2]}};
}
template <class Of>
Moving<Of> operator*(const solver::Interval& f, const Moving<Of>& a) {
  return {f * a.value, f * a.center, {f * a.by[0], f * a.by[1], f * a.by[2]}};
}
template <class Of>
Moving<Of> operator*(const MovingNumber& f, const Moving<Of>& a) {
  Moving<Of> out(f.value * a.value, f.center * a.center, {});
  for (std::size_t j = 0; j < 3; ++j) out.by[j] = f.by[j] * a.value + f.value * a.by[j];
  return out;
}
inline MovingVector cross(const MovingVector& a, const MovingVector& b) {
  MovingVector out(cross(a.value, b.value), cross(a.center, b.center), {});
  for (std::size_t j = 0; j < 3; ++j) out.by[j] = cross(a.by[j], b.value) + cross(a.value, b.by[j]);
  return out;
}
inline MovingNumber size(const MovingVector& v) {
  MovingNumber out(size(v.value), size(v.center), {});
  for (std::size_t j = 0; j < 3; ++j) out.by[j] = dot(v.value, v.by[j]) / out.value;
  return out;
}

/// Narrows the value to what the middle and the derivatives allow (the mean value theorem). After
/// many steps that is closer than the value itself.
inline void sharpen(MovingNumber& a, const Reach& reach) {
  const solver::Interval moved = a.by[0] * reach[0] + a.by[1] * reach[1] + a.by[2] * reach[2];
  a.value = common(a.value, a.center + moved);
}
inline void sharpen(MovingVector& a, const Reach& reach) {
  for (std::size_t i = 0; i < 3; ++i) {
    const solver::Interval moved =
        a.by[0][i] * reach[0] + a.by[1][i] * reach[1] + a.by[2][i] * reach[2];
    a.value[i] = common(a.value[i], a.center[i] + moved);
  }
}

}  // namespace backbend::validate
