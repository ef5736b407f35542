#include "skin/body/body_curve.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <glm/geometric.hpp>
#include <utility>

namespace backbend::skin {
namespace {

/// Second derivatives of a cubic spline at its knots: the tridiagonal system, solved by
/// elimination. Natural: straight at the ends. Level: its slope at the ends is 0.
template <typename T>
std::vector<T> spline_moments(const std::vector<double>& knot, const std::vector<T>& value,
                              bool level) {
  const std::size_t n = knot.size();
  std::vector<T> moment(n, T(0.0));
  if (n < 2) return moment;
  std::vector<double> upper(n, 0.0);
  if (level) {
    const double after = knot[1] - knot[0];
    moment[0] = 3.0 * (value[1] - value[0]) / (after * after);
    upper[0] = 0.5;
  }
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double before = knot[i] - knot[i - 1], after = knot[i + 1] - knot[i];
    const T bend = 6.0 * ((value[i + 1] - value[i]) / after - (value[i] - value[i - 1]) / before);
    const double pivot = 2.0 * (before + after) - before * upper[i - 1];
    upper[i] = after / pivot;
    moment[i] = (bend - before * moment[i - 1]) / pivot;
  }
  if (level) {
    const double before = knot[n - 1] - knot[n - 2];
    const T bend = -6.0 * (value[n - 1] - value[n - 2]) / before;
    moment[n - 1] = (bend - before * moment[n - 2]) / (before * (2.0 - upper[n - 2]));
  }
  for (std::size_t i = n - 1; i-- > 0;) moment[i] -= upper[i] * moment[i + 1];
  return moment;
}

}  // namespace

BodyCurve::BodyCurve(const std::vector<glm::dvec3>& points) : point_(points) {
  assert(points.size() >= 2);
  knot_.assign(1, 0.0);
  for (std::size_t i = 1; i < points.size(); ++i) {
    knot_.push_back(knot_.back() + glm::distance(points[i - 1], points[i]));
  }
  moment_ = spline_moments(knot_, point_, false);

  for (std::size_t i = 0; i + 1 < knot_.size(); ++i) {
    const double h = knot_[i + 1] - knot_[i];
    piece_.push_back(
        {h, point_[i], point_[i + 1], moment_[i], moment_[i + 1], (point_[i + 1] - point_[i]) / h});
  }

  // Per interval: enough to start Newton's method in the right place, few on a long chain.
  const int steps = points.size() == 2 ? 1 : points.size() < 8 ? 16 : 4;
  for (std::size_t i = 0; i + 1 < knot_.size(); ++i) {
    for (int k = i == 0 ? 0 : 1; k <= steps; ++k) {
      sample_.push_back(knot_[i] + (knot_[i + 1] - knot_[i]) * k / steps);
    }
  }
  std::vector<glm::dvec3> place;
  for (const double u : sample_) place.push_back(point(u));
  arc_.assign(1, 0.0);
  for (std::size_t i = 1; i < sample_.size(); ++i) {
    // Simpson's rule on the speed.
    const double h = sample_[i] - sample_[i - 1];
    const double speed = glm::length(derivative(sample_[i - 1])) +
                         4.0 * glm::length(derivative(sample_[i - 1] + 0.5 * h)) +
                         glm::length(derivative(sample_[i]));
    arc_.push_back(arc_.back() + speed * h / 6.0);
  }
  for (std::size_t i = 0; i + 1 < place.size(); ++i) {
    const glm::dvec3 along = place[i + 1] - place[i];
    edge_.push_back({place[i], along, glm::dot(along, along)});
  }
  for (std::size_t i = 0; i < edge_.size(); i += kBlock) {
    const std::size_t end = std::min(i + kBlock, edge_.size());
    Ball ball{0.5 * (place[i] + place[end]), 0.0};
    for (std::size_t k = i; k <= end; ++k) {
      ball.radius = std::max(ball.radius, glm::distance(ball.center, place[k]));
    }
    ball_.push_back(ball);
  }
}

BodyCurve::Local BodyCurve::local(Lanes u) const {
  const Lanes inside = clamped(u, 0.0, knot_.back());
  const LaneRows row(knot_, inside);
  const auto number = [&](double Piece::*of) {
    return row.pick([&](std::size_t i) { return piece_[i].*of; });
  };
  const auto vector = [&](glm::dvec3 Piece::*of) {
    return row.pick_vector([&](std::size_t i) -> const glm::dvec3& { return piece_[i].*of; });
  };
  const Lanes knot = row.pick([&](std::size_t i) { return knot_[i]; });
  const Lanes h = number(&Piece::h), b = (inside - knot) / h, a = 1.0 - b;
  const LaneVector from = vector(&Piece::from), to = vector(&Piece::to);
  const LaneVector before = vector(&Piece::moment_from), after = vector(&Piece::moment_to);

  Local out;
  out.derivative = vector(&Piece::chord) +
                   h / 6.0 * ((3.0 * b * b - 1.0) * after - (3.0 * a * a - 1.0) * before);
  const Lanes::Mask below = Lanes(0.0) > u, above = u > knot_.back();
  out.point =
      a * from + b * to + h * h / 6.0 * ((a * a * a - a) * before + (b * b * b - b) * after);
  out.second = a * before + b * after;
  if (any(below | above)) {
    out.point = select(below, LaneVector(point_.front()) + u * out.derivative, out.point);
    out.point =
        select(above, LaneVector(point_.back()) + (u - knot_.back()) * out.derivative, out.point);
  }
  const Lanes::Mask outside = (u <= Lanes(0.0)) | (u >= Lanes(knot_.back()));
  out.second = select(outside, LaneVector(glm::dvec3(0.0)), out.second);
  return out;
}

glm::dvec3 BodyCurve::point(double u) const { return lane(local(u).point, 0); }

glm::dvec3 BodyCurve::derivative(double u) const { return lane(local(u).derivative, 0); }

double BodyCurve::parameter(double arc) const {
  const std::size_t i = LaneRows(arc_, arc)[0];
  return sample_[i] + (sample_[i + 1] - sample_[i]) * (arc - arc_[i]) / (arc_[i + 1] - arc_[i]);
}

glm::dvec3 BodyCurve::at(double arc) const { return point(parameter(arc)); }

glm::dvec3 BodyCurve::tangent(double arc) const {
  return glm::normalize(derivative(parameter(arc)));
}

/// The parameter of the nearest place on the table's edges.
Lanes BodyCurve::nearest_in_table(const LaneVector& p) const {
  Lanes best = INFINITY, best2 = INFINITY, u = 0.0;
  const std::size_t edges = edge_.size();
  const auto visit = [&](std::size_t i) {
    const Edge& edge = edge_[i];
    const LaneVector from = edge.from, along = edge.along;
    Lanes t = dot(p - from, along) / edge.length2;
    if (i > 0) t = larger(t, 0.0);           // only the outer edges
    if (i + 1 < edges) t = smaller(t, 1.0);  // go on beyond their ends
    const LaneVector off = p - (from + t * along);
    const Lanes d2 = dot(off, off);
    Lanes::Mask nearer = best2 > d2;
    if (!any(nearer)) return;
    const Lanes d = square_root(d2);
    nearer = nearer & (best > d);  // squares tell apart what is equally far
    best = select(nearer, d, best);
    best2 = select(nearer, d2, best2);
    u = select(nearer, Lanes(sample_[i]) + t * Lanes(sample_[i + 1] - sample_[i]), u);
  };
  // Of edges equally near the first counts, so their order is part of the result.
  visit(0);
  if (edges > 1) visit(edges - 1);
  for (std::size_t i = 8; i + 1 < edges; i += 16) visit(i);  // a fair guess, to skip by
  for (std::size_t block = 0; block < ball_.size(); ++block) {
    const Lanes apart = solver::length(p - LaneVector(ball_[block].center)) - ball_[block].radius;
    if (all(apart > best * (1.0 + 1e-9))) continue;  // 1e-9: rounding
    const std::size_t end = std::min((block + 1) * kBlock, edges - 1);
    for (std::size_t i = std::max<std::size_t>(block * kBlock, 1); i < end; ++i) visit(i);
  }
  return u;
}

BodyCurve::Feet BodyCurve::feet(const LaneVector& p) const {
  // The nearest table edge, then Newton's method on (p - c(u)) . c'(u) = 0.
  Lanes u = nearest_in_table(p);
  Local here = local(u);
  if (edge_.size() > 1) {
    Lanes::Mask going = Lanes(0.0) <= Lanes(0.0);
    for (int step = 0; step < 5; ++step) {
      const LaneVector off = p - here.point;
      const Lanes speed2 = dot(here.derivative, here.derivative);
      const Lanes curvature = speed2 - dot(off, here.second);
      going = going & (curvature > 0.1 * speed2);  // not at the centre of a bend
      if (!any(going)) break;
      const Lanes move = dot(off, here.derivative) / curvature;
      u = select(going, u + move, u);
      here = local(u);
      going = going & (absolute(move) >= Lanes(1e-12 * knot_.back()));
      if (!any(going)) break;
    }
  }
  const Lanes speed = solver::length(here.derivative);
  Feet feet;
  feet.at = here.point;
  feet.tangent = here.derivative / speed;
  const LaneRows row(sample_, u);
  const Lanes from = row.pick([&](std::size_t i) { return arc_[i]; });
  const Lanes whole = row.pick([&](std::size_t i) { return arc_[i + 1] - arc_[i]; });
  const Lanes start = row.pick([&](std::size_t i) { return sample_[i]; });
  const Lanes width = row.pick([&](std::size_t i) { return sample_[i + 1] - sample_[i]; });
  feet.arc = from + whole * (u - start) / width;
  feet.arc =
      select(u >= Lanes(knot_.back()), Lanes(arc_.back()) + (u - knot_.back()) * speed, feet.arc);
  feet.arc = select(u <= Lanes(0.0), u * speed, feet.arc);
  return feet;
}

BodyCurve::Foot BodyCurve::nearest(const glm::dvec3& p) const {
  const Feet found = feet(LaneVector(p));
  return {found.arc[0], lane(found.at, 0), lane(found.tangent, 0)};
}

BodyProfile::BodyProfile(std::vector<double> at, const std::vector<double>& value)
    : at_(std::move(at)) {
  const std::vector<double> moment = spline_moments(at_, value, true);
  for (std::size_t i = 0; i + 1 < at_.size(); ++i) {
    piece_.push_back({value[i], value[i + 1], moment[i], moment[i + 1]});
  }
  // One place: constant.
  if (at_.size() == 1) piece_.push_back({value[0], value[0], 0.0, 0.0}), at_.push_back(at_[0]);
}

Lanes BodyProfile::choose(Lanes::Mask which, const BodyProfile& yes, const BodyProfile& no,
                          Lanes at, Lanes* slope) {
  const std::vector<double>& place = yes.at_;
  const LaneRows row(place, at);
  const int bits = which.bits();
  const auto piece = [&](int lane) {
    return _mm256_loadu_pd(((bits >> lane & 1) != 0 ? yes : no).piece_[row[lane]].data());
  };
  // Four rows to four columns.
  const __m256d p0 = piece(0), p1 = piece(1), p2 = piece(2), p3 = piece(3);
  const __m256d even01 = _mm256_unpacklo_pd(p0, p1), odd01 = _mm256_unpackhi_pd(p0, p1);
  const __m256d even23 = _mm256_unpacklo_pd(p2, p3), odd23 = _mm256_unpackhi_pd(p2, p3);
  const Lanes from(_mm256_permute2f128_pd(even01, even23, 0x20));
  const Lanes to(_mm256_permute2f128_pd(odd01, odd23, 0x20));
  const Lanes before(_mm256_permute2f128_pd(even01, even23, 0x31));
  const Lanes after(_mm256_permute2f128_pd(odd01, odd23, 0x31));

  const Lanes start = row.pick([&](std::size_t i) { return place[i]; });
  const Lanes h = row.pick([&](std::size_t i) { return place[i + 1] - place[i]; });
  const Lanes b = (at - start) / h, a = 1.0 - b;
  const Lanes rise =
      (to - from) / h + h / 6.0 * ((3.0 * b * b - 1.0) * after - (3.0 * a * a - 1.0) * before);
  const Lanes value =
      a * from + b * to + h * h / 6.0 * ((a * a * a - a) * before + (b * b * b - b) * after);
  const Lanes::Mask below = at <= Lanes(place.front()), above = at >= Lanes(place.back());
  *slope = select(below | above, 0.0, rise);
  return select(below, from, select(above, to, value));
}

double BodyProfile::operator()(double at, double* slope) const {
  Lanes slopes;
  const Lanes value = choose(Lanes(0.0) <= Lanes(0.0), *this, *this, at, &slopes);
  *slope = slopes[0];
  return value[0];
}

}  // namespace backbend::skin
