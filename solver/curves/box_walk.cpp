#include "solver/curves/box_walk.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "solver/math/bezier.h"

namespace backbend::solver {
namespace {

const BoxReal kEnd(1.0);

/// The least that two vectors of an enclosure have in common, each one of any pose.
double least_product(const BoxVector& v) {
  return (v.x.value * v.x.value + v.y.value * v.y.value + v.z.value * v.z.value).lo;
}

}  // namespace

BoxWalk::BoxWalk(const std::array<BoxVector, 4>& cv)
    : cv_(cv), end_velocity_(BoxReal(3.0) * (cv[3] - cv[2])) {
  for (std::size_t i = 0; i < cv.size(); ++i)
    middle_[i] = {cv[i].x.center.middle(), cv[i].y.center.middle(), cv[i].z.center.middle()};
}

BoxVector BoxWalk::velocity(const BoxReal& u) const {
  return bezier_derivative(cv_, smaller(u, kEnd));
}

BoxVector BoxWalk::point(const BoxReal& u) const {
  const BoxReal on = smaller(u, kEnd);
  return bezier_point(cv_, on) + (u - on) * end_velocity_;
}

BoxVector BoxWalk::chord(const BoxReal& u, const BoxReal& v) const {
  if (v.value.hi <= 1.0) return bezier_chord(cv_, u, v);
  if (u.value.lo >= 1.0) return end_velocity_;
  const BoxReal from = smaller(u, kEnd), to = smaller(v, kEnd);
  BoxReal on = (to - from) / (v - u);  // share of the way that lies on the curve
  on.value = common(on.value, Interval(0.0, 1.0));
  return end_velocity_ + on * (bezier_chord(cv_, from, to) - end_velocity_);
}

double BoxWalk::guess(double from, double distance) const {
  const glm::dvec3 end = 3.0 * (middle_[3] - middle_[2]);
  const auto velocity_at = [&](double u) { return bezier_derivative(middle_, std::min(u, 1.0)); };
  const auto point_at = [&](double u) {
    return bezier_point(middle_, std::min(u, 1.0)) + std::max(0.0, u - 1.0) * end;
  };
  const glm::dvec3 start = point_at(from);
  double u = from + distance / glm::length(velocity_at(from));
  for (int i = 0; i < 12; ++i) {
    const glm::dvec3 way = point_at(u) - start;
    const double length = glm::length(way), slope = glm::dot(way, velocity_at(u)) / length;
    u += (distance - length) / slope;
  }
  return u;
}

BoxReal BoxWalk::step(const BoxReal& from, const BoxReal& distance) const {
  if (!from.is_finite() || !distance.is_finite() || !(distance.value.lo > 0.0))
    return BoxReal::undefined();
  const double own = guess(from.center.middle(), distance.center.middle());
  if (!std::isfinite(own)) return BoxReal::undefined();
  const BoxReal at_guess(own), start(from.value);
  const BoxReal error = (at_guess - from) * length(chord(from, at_guess)) - distance;
  if (!error.is_finite()) return BoxReal::undefined();
  // How fast the distance grows with the place, or falls with the start, at one of some chord.
  const auto growth = [&](const BoxVector& bone, const BoxReal& size, const BoxReal& u) {
    return (dot(bone, velocity(u)) / size).value;
  };
  // Interval Newton, as BoxArc's.
  const double speed = length(velocity(at_guess)).value.lo;
  double reach = 1.5 * error.value.most() / std::max(1e-300, speed) + 1e-13;
  for (int i = 0; i < 8; ++i, reach *= 1.6) {
    const Interval u = Interval(own) + Interval(-reach, reach);
    // While the velocity stays within a right angle of itself, all the way from `from` on, the
    // distance grows: there is one place and no other before it.
    const Interval all(std::min(from.value.lo, u.lo), u.hi);
    if (!(least_product(velocity(BoxReal(all))) > 0.0)) return BoxReal::undefined();
    const BoxVector any = chord(start, BoxReal(u));
    const Interval slope = growth(any, length(any), BoxReal(u));
    if (!(slope.lo > 0.0)) return BoxReal::undefined();
    const Interval root = Interval(own) - error.value / slope;
    if (!(root.lo > u.lo && root.hi < u.hi)) continue;
    // By the implicit function theorem. Of the chord between fixed parameters only the curve's own
    // change is in the slopes.
    const BoxReal to(root);
    const BoxVector bone = chord(start, to);
    const BoxReal size = length(bone);
    const Interval apart = common(root - from.value, distance.value / size.value);
    const Interval at_start = growth(bone, size, start), at_end = growth(bone, size, to);
    BoxReal r;
    r.center = common(root, Interval(own) - error.center / slope);
    double spread = 0.0;
    for (std::size_t j = 0; j < kBoxVariables; ++j) {
      r.slope[j] = (distance.slope[j] + at_start * from.slope[j] - apart * size.slope[j]) / at_end;
      spread = rounding::above(spread + r.slope[j].most());
    }
    if (!std::isfinite(spread)) return BoxReal::undefined();
    r.value = common(root, r.center + Interval(-spread, spread));
    return r.is_finite() ? r : BoxReal::undefined();
  }
  return BoxReal::undefined();
}

}  // namespace backbend::solver
