#include "skin/body/body_curve.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <glm/geometric.hpp>

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

std::size_t interval(const std::vector<double>& knot, double u) {
  const auto above = std::upper_bound(knot.begin() + 1, knot.end() - 1, u);
  return static_cast<std::size_t>(above - knot.begin()) - 1;
}

}  // namespace

BodyCurve::BodyCurve(const std::vector<glm::dvec3>& points) : point_(points) {
  assert(points.size() >= 2);
  knot_.assign(1, 0.0);
  for (std::size_t i = 1; i < points.size(); ++i) {
    knot_.push_back(knot_.back() + glm::distance(points[i - 1], points[i]));
  }
  moment_ = spline_moments(knot_, point_, false);

  // Per interval: enough to start Newton's method in the right place, few on a long chain.
  const int steps = points.size() == 2 ? 1 : points.size() < 8 ? 16 : 4;
  for (std::size_t i = 0; i + 1 < knot_.size(); ++i) {
    for (int k = i == 0 ? 0 : 1; k <= steps; ++k) {
      sample_.push_back(knot_[i] + (knot_[i + 1] - knot_[i]) * k / steps);
    }
  }
  for (const double u : sample_) place_.push_back(point(u));
  arc_.assign(1, 0.0);
  for (std::size_t i = 1; i < sample_.size(); ++i) {
    // Simpson's rule on the speed.
    const double h = sample_[i] - sample_[i - 1];
    const double speed = glm::length(derivative(sample_[i - 1])) +
                         4.0 * glm::length(derivative(sample_[i - 1] + 0.5 * h)) +
                         glm::length(derivative(sample_[i]));
    arc_.push_back(arc_.back() + speed * h / 6.0);
    longest_ = std::max(longest_, glm::distance(place_[i - 1], place_[i]));
  }
}

glm::dvec3 BodyCurve::point(double u) const {
  if (u < 0.0) return point_.front() + u * derivative(0.0);
  if (u > knot_.back()) return point_.back() + (u - knot_.back()) * derivative(knot_.back());
  const std::size_t i = interval(knot_, u);
  const double h = knot_[i + 1] - knot_[i];
  const double b = (u - knot_[i]) / h, a = 1.0 - b;
  return a * point_[i] + b * point_[i + 1] +
         h * h / 6.0 * ((a * a * a - a) * moment_[i] + (b * b * b - b) * moment_[i + 1]);
}

glm::dvec3 BodyCurve::derivative(double u) const {
  u = std::clamp(u, 0.0, knot_.back());
  const std::size_t i = interval(knot_, u);
  const double h = knot_[i + 1] - knot_[i];
  const double b = (u - knot_[i]) / h, a = 1.0 - b;
  return (point_[i + 1] - point_[i]) / h +
         h / 6.0 * ((3.0 * b * b - 1.0) * moment_[i + 1] - (3.0 * a * a - 1.0) * moment_[i]);
}

glm::dvec3 BodyCurve::second(double u) const {
  if (u <= 0.0 || u >= knot_.back()) return glm::dvec3(0.0);
  const std::size_t i = interval(knot_, u);
  const double b = (u - knot_[i]) / (knot_[i + 1] - knot_[i]);
  return (1.0 - b) * moment_[i] + b * moment_[i + 1];
}

double BodyCurve::parameter(double arc) const {
  const std::size_t i = interval(arc_, arc);
  return sample_[i] + (sample_[i + 1] - sample_[i]) * (arc - arc_[i]) / (arc_[i + 1] - arc_[i]);
}

glm::dvec3 BodyCurve::at(double arc) const { return point(parameter(arc)); }

glm::dvec3 BodyCurve::tangent(double arc) const {
  return glm::normalize(derivative(parameter(arc)));
}

BodyCurve::Foot BodyCurve::nearest(const glm::dvec3& p) const {
  // The nearest table edge, then Newton's method on (p - c(u)) . c'(u) = 0.
  double best = INFINITY, u = 0.0;
  const std::size_t edges = place_.size() - 1;
  const auto visit = [&](std::size_t i) {
    const glm::dvec3 along = place_[i + 1] - place_[i];
    double t = glm::dot(p - place_[i], along) / glm::dot(along, along);
    if (i > 0) t = std::max(t, 0.0);          // only the outer edges
    if (i + 1 < edges) t = std::min(t, 1.0);  // go on beyond their ends
    const double d = glm::distance(p, place_[i] + t * along);
    if (d < best) {
      best = d;
      u = sample_[i] + t * (sample_[i + 1] - sample_[i]);
    }
  };
  visit(0);
  if (edges > 1) visit(edges - 1);
  for (std::size_t i = 8; i + 1 < edges; i += 16) visit(i);  // a fair guess, to skip by
  for (std::size_t i = 1; i + 1 < edges;) {
    visit(i);
    // Edges that end before the curve can have come nearer than `best` need no look.
    const double spare = glm::distance(p, place_[i + 1]) - best;
    i += 1 + static_cast<std::size_t>(std::max(spare / longest_, 0.0));
  }
  if (edges > 1) {
    for (int step = 0; step < 5; ++step) {
      const glm::dvec3 off = p - point(u), slope = derivative(u);
      const double speed2 = glm::dot(slope, slope);
      const double curvature = speed2 - glm::dot(off, second(u));
      if (curvature <= 0.1 * speed2) break;  // at the centre of a bend
      const double move = glm::dot(off, slope) / curvature;
      u += move;
      if (std::abs(move) < 1e-12 * knot_.back()) break;
    }
  }
  Foot foot;
  const glm::dvec3 slope = derivative(u);
  const double speed = glm::length(slope);
  foot.at = point(u);
  foot.tangent = slope / speed;
  if (u <= 0.0) {
    foot.arc = u * speed;
  } else if (u >= knot_.back()) {
    foot.arc = arc_.back() + (u - knot_.back()) * speed;
  } else {
    const std::size_t i = interval(sample_, u);
    foot.arc = arc_[i] + (arc_[i + 1] - arc_[i]) * (u - sample_[i]) / (sample_[i + 1] - sample_[i]);
  }
  return foot;
}

BodyProfile::BodyProfile(std::vector<double> at, std::vector<double> value)
    : at_(std::move(at)), value_(std::move(value)), moment_(spline_moments(at_, value_, true)) {}

double BodyProfile::operator()(double at, double* slope) const {
  *slope = 0.0;
  if (at <= at_.front()) return value_.front();
  if (at >= at_.back()) return value_.back();
  const std::size_t i = interval(at_, at);
  const double h = at_[i + 1] - at_[i];
  const double b = (at - at_[i]) / h, a = 1.0 - b;
  *slope = (value_[i + 1] - value_[i]) / h +
           h / 6.0 * ((3.0 * b * b - 1.0) * moment_[i + 1] - (3.0 * a * a - 1.0) * moment_[i]);
  return a * value_[i] + b * value_[i + 1] +
         h * h / 6.0 * ((a * a * a - a) * moment_[i] + (b * b * b - b) * moment_[i + 1]);
}

}  // namespace backbend::skin
