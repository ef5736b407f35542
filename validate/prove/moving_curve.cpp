#include "validate/prove/moving_curve.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace backbend::validate {
namespace {

using solver::Interval;

const auto value_of = [](const MovingVector& v) -> const Vec& { return v.value; };
const auto center_of = [](const MovingVector& v) -> const Vec& { return v.center; };
auto slope_of(std::size_t channel) {
  return [channel](const MovingVector& v) -> const Vec& { return v.by[channel]; };
}

}  // namespace

template <class Part>
Vec MovingCurve::change_at(const Piece& piece, const Interval& t, const Part& part) {
  return Interval(2.0) * ((Interval(1.0) - t) * (part(piece[1]) - part(piece[0])) +
                          t * (part(piece[2]) - part(piece[1])));
}

template <class Part>
Vec MovingCurve::at(const Piece& piece, const Interval& t, const Part& part) {
  const Interval m = t.middle(), s = Interval(1.0) - m;
  const Vec middle = square(s) * part(piece[0]) + Interval(2.0) * s * m * part(piece[1]) +
                     square(m) * part(piece[2]);
  if (t.lo == t.hi) return middle;
  return middle + (t - m) * change_at(piece, t, part);
}

template <class Of>
Vec MovingCurve::over(const Interval& u, const Of& of) const {
  const double first = std::clamp(std::floor(u.lo), 0.0, last_piece());
  const double behind = std::clamp(std::ceil(u.hi) - 1.0, first, last_piece());
  std::optional<Vec> all;
  for (double k = first; k <= behind; ++k) {
    const Interval own(k == first ? u.lo : k, k == behind ? u.hi : k + 1.0);
    const Vec here = of(piece_[static_cast<std::size_t>(k)], own - Interval(k));
    all = all ? hull(*all, here) : here;
  }
  return *all;
}

/// By Simpson's rule, which is exact within a piece.
template <class Part>
Vec MovingCurve::integral(const Interval& from, const Interval& to, const Part& part) const {
  Vec sum{};
  Interval before = from;
  const auto add = [&](const Interval& next) {
    const Interval step = next - before;
    // Where the two may be one, or in either order, by the mean.
    if (next.lo > before.hi) {
      const Vec middle = at(Interval(0.5) * (before + next), part);
      sum =
          sum + step / Interval(6.0) * (at(before, part) + Interval(4.0) * middle + at(next, part));
    } else {
      sum = sum + step * at(hull(before, next), part);
    }
    before = next;
  };
  for (double knot = std::floor(from.lo) + 1.0; knot < to.hi && knot <= last_piece(); ++knot)
    if (knot > from.lo) add(knot);
  add(to);
  return sum;
}

MovingCurve::MovingCurve(const std::vector<MovingVector>& step, const Reach& reach, int panels)
    : end_(static_cast<double>(step.size() - 2)), reach_(reach), panels_(panels) {
  // Its velocity is a quadratic B-spline of three times the steps over the knots that each spans.
  const std::size_t pieces = step.size() - 2;
  std::vector<MovingVector> velocity;
  for (std::size_t i = 0; i < step.size(); ++i) {
    const std::size_t spans = std::min({i + 1, step.size() - i, pieces, std::size_t(3)});
    velocity.push_back(Interval(3.0) / Interval(double(spans)) * step[i]);
  }
  const auto between = [&](std::size_t i) {
    return Interval(0.5) * (velocity[i] + velocity[i + 1]);
  };
  for (std::size_t k = 0; k < pieces; ++k) {
    piece_.push_back({k == 0 ? velocity.front() : between(k), velocity[k + 1],
                      k + 1 == pieces ? velocity.back() : between(k + 1)});
    for (int i = 0; i < panels; ++i) {
      const double from = double(i) / panels, to = double(i + 1) / panels;
      panel_.push_back(length_of(piece_.back(), from, to, 0));
      length_ = length_ + panel_.back();
    }
  }
  sharpen(length_, reach_);
  piece_.push_back({velocity.back(), velocity.back(), velocity.back()});
}

/// Between two places of one piece. Cut finer where the speed varies much.
MovingNumber MovingCurve::length_of(const Piece& piece, double from, double to, int depth) const {
  constexpr int kDeepest = 7;
  const Interval t(from, to), h = Interval(to) - Interval(from), two(2.0);
  const double m = 0.5 * (from + to);
  const Vec v = at(piece, t, center_of), v1 = change_at(piece, t, center_of),
            v2 = two * (piece[0].center - two * piece[1].center + piece[2].center);
  const Interval speed = size(v);
  const bool wide = to - from > 1.5 / panels_ || !(speed.lo > 0.5 * speed.hi);
  if (wide && depth < kDeepest)
    return length_of(piece, from, m, depth + 1) + length_of(piece, m, to, depth + 1);

  // Taylor's formula about m, which is the middle but for rounding: `off` takes that.
  const Interval off(-1e-15, 1e-15);
  const Interval along = dot(v, v1) / speed;
  const Interval bend = (dot(v1, v1) + dot(v, v2) - square(along)) / speed;
  MovingNumber out;
  out.center =
      h * (size(at(piece, m, center_of)) + off * along + square(h) / Interval(24.0) * bend);
  const Vec over = at(piece, t, value_of), over1 = change_at(piece, t, value_of),
            here = at(piece, m, value_of);
  const Interval fast = size(over), at_m = size(here), grows = dot(over, over1) / square(fast);
  out.value = h * fast;
  for (std::size_t j = 0; j < 3; ++j) {
    const auto part = slope_of(j);
    const Vec by = at(piece, t, part);
    const Interval change =
        (dot(over1, by) + dot(over, change_at(piece, t, part)) - dot(over, by) * grows) / fast;
    const double vary =
        (square(h) / Interval(8.0) * (Interval(change.hi) - Interval(change.lo)) + h * off * change)
            .most();
    out.by[j] = h * dot(here, at(piece, m, part)) / at_m + Interval(-vary, vary);
  }
  return out;
}

MovingNumber MovingCurve::length_between(double from, double to) const {
  MovingNumber sum;
  const double count = panels_;
  for (double i = std::floor(from * count); i < to * count; ++i) {
    const auto panel = static_cast<std::size_t>(i);
    const double begin = std::max(i / count, from), end = std::min((i + 1.0) / count, to);
    if (!(begin < end)) continue;
    if (begin == i / count && end == (i + 1.0) / count) {
      sum = sum + panel_[panel];
    } else {
      const auto piece = panel / static_cast<std::size_t>(panels_);
      sum = sum + length_of(piece_[piece], begin - double(piece), end - double(piece), 0);
    }
  }
  return sum;
}

std::optional<MovingCurve::Place> MovingCurve::place_at(const MovingNumber& length) const {
  double left = length.center.middle(), guess = end_;
  for (std::size_t i = 0; i < panel_.size(); ++i) {
    const double own = panel_[i].center.middle();
    if (left < own) {
      guess = (double(i) + std::max(left / own, 0.0)) / panels_;
      break;
    }
    left -= own;
  }

  // An interval Newton step: the length grows with the parameter by the speed.
  MovingNumber miss = length_between(0.0, guess) - length;
  sharpen(miss, reach_);
  const Interval now = size(at(guess, value_of));
  if (!(now.lo > 0.0) || !miss.value.is_finite()) return std::nullopt;
  double reach = 1.3 * miss.value.most() / now.lo + 1e-12;
  for (int i = 0; i < 6; ++i, reach *= 2.0) {
    const Interval u = Interval(guess) + Interval(-reach, reach);
    if (u.lo < 0.0 || u.hi > last_piece() + 1.0) return std::nullopt;
    const Vec v = at(u, value_of);
    const Interval speed = size(v);
    if (!(speed.lo > 0.0)) return std::nullopt;
    const Interval root = Interval(guess) - miss.value / speed;
    if (!(root.lo > u.lo && root.hi < u.hi)) continue;
    Place place{{root, Interval(guess) - miss.center / speed, {}}, {}};
    for (std::size_t j = 0; j < 3; ++j) {
      const Interval faster = dot(v, at(u, slope_of(j))) / speed;
      place.slides[j] = -(miss.by[j] + (root - Interval(guess)) * faster);
      place.u.by[j] = place.slides[j] / speed;
    }
    sharpen(place.u, reach_);
    return place;
  }
  return std::nullopt;
}

std::optional<MovingCurve::Place> MovingCurve::share(int part, int parts) const {
  if (part == 0) return start();
  if (part == parts) return end();
  return place_at(Interval(part) / Interval(parts) * length_);
}

/// Whether two velocities of a stretch may be a right angle apart.
bool MovingCurve::turns_far(const Interval& u) const {
  constexpr int kParts = 8;
  const Vec middle = at(u.middle(), value_of);
  for (int i = 0; i < kParts; ++i) {
    const auto cut = [&](int k) { return u.lo + (u.hi - u.lo) * k / kParts; };
    const Vec v = at(Interval(cut(i), i + 1 == kParts ? u.hi : cut(i + 1)), value_of);
    // Within 45 degrees of the middle's.
    if (!(dot(v, middle).lo > (Interval(0.7072) * size(v) * size(middle)).hi)) return true;
  }
  return false;
}

/// By an interval Newton step for the distance, which grows with the parameter as far as the curve
/// turns by less than a right angle.
std::optional<MovingCurve::Place> MovingCurve::step(const Place& from, const MovingNumber& bone,
                                                    const glm::dmat3& axes) const {
  const double start = from.u.center.middle();
  double guess = start;
  for (int i = 0; i < 8; ++i) {
    const double gone = glm::length(middle_of(integral(start, guess, center_of)));
    const double step =
        (bone.center.middle() - gone) / glm::length(middle_of(at(guess, center_of)));
    guess += step;
    if (!(guess > start && guess < last_piece() + 1.0)) return std::nullopt;
    if (std::abs(step) < 1e-13) break;
  }
  MovingNumber miss = size(way(from, {MovingNumber(Interval(guess)), {}}, axes)) - bone;
  sharpen(miss, reach_);
  if (!miss.value.is_finite()) return std::nullopt;
  double reach = 1.3 * miss.value.most() / size(at(guess, value_of)).lo + 1e-12;
  for (int i = 0; i < 6; ++i, reach *= 2.0) {
    const Interval u = Interval(guess) + Interval(-reach, reach);
    if (!(u.lo > from.u.value.hi && u.hi <= last_piece() + 1.0)) return std::nullopt;
    if (turns_far(hull(from.u.value, u))) return std::nullopt;
    const Vec toward = unit(on_axes(axes, integral(from.u.value, u, value_of)));
    const Vec fast = on_axes(axes, at(u, value_of));
    const Interval speed = size(fast), arrives = dot(unit(fast), toward);
    const Interval rise = speed * arrives;
    const Interval root = Interval(guess) - miss.value / rise;
    if (!(root.lo > u.lo && root.hi < u.hi)) continue;
    Place place{{root, Interval(guess) - miss.center / rise, {}}, {}};
    const Interval leaves = dot(unit(on_axes(axes, at(from.u.value, value_of))), toward);
    for (std::size_t j = 0; j < 3; ++j) {
      const Vec moves = on_axes(axes, integral(from.u.value, root, slope_of(j)));
      place.slides[j] = (bone.by[j] + from.slides[j] * leaves - dot(toward, moves)) / arrives;
      place.u.by[j] = place.slides[j] / speed;
    }
    sharpen(place.u, reach_);
    return place;
  }
  return std::nullopt;
}

MovingVector MovingCurve::velocity(const Place& place, const glm::dmat3& axes) const {
  const Interval u = place.u.value;
  MovingVector out(on_axes(axes, at(u, value_of)), on_axes(axes, at(place.u.center, center_of)),
                   {});
  const Vec change = on_axes(axes, over(u, [&](const Piece& piece, const Interval& t) {
                               return change_at(piece, t, value_of);
                             }));
  for (std::size_t j = 0; j < 3; ++j)
    out.by[j] = on_axes(axes, at(u, slope_of(j))) + place.u.by[j] * change;
  sharpen(out, reach_);
  return out;
}

glm::dvec3 MovingCurve::velocity_about(const Place& place) const {
  return middle_of(at(place.u.center, center_of));
}

MovingVector MovingCurve::way(const Place& from, const Place& to, const glm::dmat3& axes) const {
  const Interval u0 = from.u.value, u1 = to.u.value;
  MovingVector out(on_axes(axes, integral(u0, u1, value_of)),
                   on_axes(axes, integral(from.u.center, to.u.center, center_of)), {});
  const Vec leaves = on_axes(axes, at(u0, value_of)), arrives = on_axes(axes, at(u1, value_of));
  for (std::size_t j = 0; j < 3; ++j) {
    out.by[j] =
        on_axes(axes, integral(u0, u1, slope_of(j))) + to.u.by[j] * arrives - from.u.by[j] * leaves;
  }
  sharpen(out, reach_);
  return out;
}

/// The derivative is V(to) to' - V(from) from' and the integral of V' between them. The first two
/// are T(to) slides(to) - T(from) slides(from), T the unit tangents, which are nearly one: what
/// they have in common goes with the difference of the slides. That is the arc's derivative less
/// the integral of T . V', and known much better than either.
MovingVector MovingCurve::way(const Place& from, const Place& to, const MovingNumber& arc,
                              const glm::dmat3& axes) const {
  const Interval u0 = from.u.value, u1 = to.u.value;
  MovingVector out(on_axes(axes, integral(u0, u1, value_of)),
                   on_axes(axes, integral(from.u.center, to.u.center, center_of)), {});
  const double begin = from.u.center.middle(), end = to.u.center.middle();
  const MovingNumber between = length_between(begin, end);
  const auto tangent = [&](const Interval& u) { return unit(on_axes(axes, at(u, value_of))); };
  const auto slope = [&](std::size_t j, const Interval& u) {
    return on_axes(axes, at(u, slope_of(j)));
  };
  const Interval near0 = hull(u0, begin), near1 = hull(u1, end);
  const Vec t0 = tangent(near0), t1 = tangent(near1), tm = tangent(0.5 * (begin + end));
  const Interval more = u1 - Interval(end), less = u0 - Interval(begin);
  for (std::size_t j = 0; j < 3; ++j) {
    const Interval stretches =
        between.by[j] + more * dot(t1, slope(j, near1)) - less * dot(t0, slope(j, near0));
    out.by[j] = (arc.by[j] - stretches) * tm + to.slides[j] * (t1 - tm) -
                from.slides[j] * (t0 - tm) + on_axes(axes, integral(u0, u1, slope_of(j)));
  }
  sharpen(out, reach_);
  return out;
}

glm::dvec3 MovingCurve::way_about(const Place& from, const Place& to) const {
  return middle_of(integral(from.u.center, to.u.center, center_of));
}

}  // namespace backbend::validate
