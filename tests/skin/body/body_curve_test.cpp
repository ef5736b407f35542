// Splines against a second solution of the same equations, in slopes instead of moments.
#include "skin/body/body_curve.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <random>

namespace backbend::skin {
namespace {

/// A cubic spline by its slopes at the knots, from a dense system: continuous second derivatives,
/// and at the ends none (natural) or slopes of 0 (level).
template <typename T>
struct Reference {
  std::vector<double> knot;
  std::vector<T> value, slope;

  Reference(std::vector<double> knots, std::vector<T> values, bool level)
      : knot(std::move(knots)), value(std::move(values)) {
    const std::size_t n = knot.size();
    std::vector<std::vector<double>> a(n, std::vector<double>(n, 0.0));
    std::vector<T> b(n, T(0.0));
    const auto step = [&](std::size_t i) { return knot[i + 1] - knot[i]; };
    const auto rise = [&](std::size_t i) { return value[i + 1] - value[i]; };
    for (std::size_t i = 1; i + 1 < n; ++i) {
      a[i][i - 1] = 1.0 / step(i - 1);
      a[i][i + 1] = 1.0 / step(i);
      a[i][i] = 2.0 * (a[i][i - 1] + a[i][i + 1]);
      b[i] = 3.0 * (rise(i - 1) / (step(i - 1) * step(i - 1)) + rise(i) / (step(i) * step(i)));
    }
    a[0][0] = a[n - 1][n - 1] = level ? 1.0 : 2.0;
    if (!level) {
      a[0][1] = a[n - 1][n - 2] = 1.0;
      b[0] = 3.0 * rise(0) / step(0);
      b[n - 1] = 3.0 * rise(n - 2) / step(n - 2);
    }
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t k = 0; k < n; ++k) {
        if (k == i) continue;
        const double factor = a[k][i] / a[i][i];
        for (std::size_t c = 0; c < n; ++c) a[k][c] -= factor * a[i][c];
        b[k] -= factor * b[i];
      }
    for (std::size_t i = 0; i < n; ++i) slope.push_back(b[i] / a[i][i]);
  }

  std::size_t piece(double u) const {
    std::size_t i = 0;
    while (i + 2 < knot.size() && u >= knot[i + 1]) ++i;
    return i;
  }
  T at(double u) const {
    const std::size_t i = piece(u);
    const double h = knot[i + 1] - knot[i], t = (u - knot[i]) / h, s = 1.0 - t;
    return s * s * (1.0 + 2.0 * t) * value[i] + t * t * (3.0 - 2.0 * t) * value[i + 1] +
           h * t * s * (s * slope[i] - t * slope[i + 1]);
  }
  T derivative(double u) const {
    const std::size_t i = piece(u);
    const double h = knot[i + 1] - knot[i], t = (u - knot[i]) / h, s = 1.0 - t;
    return 6.0 * s * t / h * (value[i + 1] - value[i]) + s * (s - 2.0 * t) * slope[i] +
           t * (t - 2.0 * s) * slope[i + 1];
  }
};

Reference<glm::dvec3> through(const std::vector<glm::dvec3>& points) {
  std::vector<double> knot(1, 0.0);
  for (std::size_t i = 1; i < points.size(); ++i)
    knot.push_back(knot.back() + glm::distance(points[i - 1], points[i]));
  return {knot, points, false};
}

/// The length of the curve up to `u`, by the trapezoidal rule on many small steps.
double length_to(const Reference<glm::dvec3>& curve, double u) {
  constexpr int kSteps = 4000;
  double sum = 0.0;
  for (int k = 0; k < kSteps; ++k)
    sum += 0.5 * u / kSteps *
           (glm::length(curve.derivative(u * k / kSteps)) +
            glm::length(curve.derivative(u * (k + 1) / kSteps)));
  return sum;
}

const std::vector<glm::dvec3> kFew = {
    {0.1, 0.2, -0.3}, {0.5, 1.1, 0.1}, {0.4, 1.7, 0.9}, {1.3, 2.2, 1.4}, {1.1, 3.4, 1.2}};
const std::vector<glm::dvec3> kMany = {{0.3, 0.1, 0.2},  {0.4, 0.9, 0.3}, {0.7, 1.5, 0.6},
                                       {0.6, 2.4, 1.0},  {0.9, 2.9, 1.6}, {1.4, 3.1, 2.2},
                                       {1.5, 3.8, 2.7},  {1.3, 4.6, 3.0}, {1.0, 5.1, 3.6},
                                       {0.2, 5.7, 3.85}, {-0.4, 6.1, 4.4}};

TEST(BodyCurve, IsTheNaturalSplineThroughItsPoints) {
  for (const auto& points : {kFew, kMany}) {
    const BodyCurve curve(points);
    const Reference<glm::dvec3> reference = through(points);
    const double end = reference.knot.back(), slack = points.size() < 8 ? 2e-6 : 2e-4;
    // By Simpson's rule on pieces of a sixteenth of a bone, of a quarter on a long chain: measured
    // 2e-7 and 1.2e-4.
    EXPECT_NEAR(curve.length(), length_to(reference, end), slack);
    for (int k = 1; k < 40; ++k) {
      const double u = end * k / 40.0;
      const glm::dvec3 on = reference.at(u), tangent = glm::normalize(reference.derivative(u));
      const glm::dvec3 aside = glm::normalize(glm::cross(tangent, glm::dvec3(0.3, -0.5, 0.8)));
      for (const double apart : {0.0, 0.02, 0.12}) {
        const BodyCurve::Foot foot = curve.nearest(on + apart * aside);
        EXPECT_LT(glm::distance(foot.at, on), 1e-9) << k << " " << apart;
        EXPECT_LT(glm::distance(foot.tangent, tangent), 1e-9) << k << " " << apart;
        // Arc lengths are interpolated in the table.
        EXPECT_NEAR(foot.arc, length_to(reference, u), 6e-3) << k;
      }
      const double arc = length_to(reference, u);
      EXPECT_LT(glm::distance(curve.at(arc), on), 6e-3) << k;
      EXPECT_LT(glm::distance(curve.tangent(arc), tangent), 1.5e-2) << k;
    }
    // At a place of the table nothing is interpolated: the points themselves.
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double arc = length_to(reference, reference.knot[i]);
      EXPECT_NEAR(curve.nearest(points[i]).arc, arc, slack);
      EXPECT_LT(glm::distance(curve.at(arc), points[i]), slack);
    }
  }
}

TEST(BodyCurve, GoesOnStraightBeyondItsEnds) {
  for (const auto& points : {kFew, kMany, {kFew[0], kFew[1]}}) {
    const BodyCurve curve(points);
    const Reference<glm::dvec3> reference = through(points);
    const glm::dvec3 first = glm::normalize(reference.derivative(0.0)),
                     last = glm::normalize(reference.derivative(reference.knot.back()));
    const glm::dvec3 before = points.front() - 0.3 * first, after = points.back() + 0.4 * last;
    EXPECT_LT(glm::distance(curve.at(curve.length()), points.back()), 1e-12);
    EXPECT_LT(glm::distance(curve.at(0.0), points.front()), 1e-12);
    EXPECT_LT(glm::distance(curve.tangent(-0.3), first), 1e-12);
    EXPECT_LT(glm::distance(curve.tangent(curve.length() + 0.4), last), 1e-12);
    const glm::dvec3 aside = glm::normalize(glm::cross(first, glm::dvec3(0.3, -0.5, 0.8)));
    const BodyCurve::Foot start = curve.nearest(before + 0.1 * aside);
    EXPECT_NEAR(start.arc, -0.3, 1e-9);
    EXPECT_LT(glm::distance(start.at, before), 1e-9);
    EXPECT_LT(glm::distance(start.tangent, first), 1e-9);
    const BodyCurve::Foot end = curve.nearest(after);
    EXPECT_NEAR(end.arc, curve.length() + 0.4, 1e-9);
    EXPECT_LT(glm::distance(end.at, after), 1e-9);
    EXPECT_LT(glm::distance(end.tangent, last), 1e-9);
    // By arc, too: as far as the table's last step says, which is not quite the speed at the end.
    EXPECT_LT(glm::distance(curve.at(-0.3), before), 0.02);
    EXPECT_LT(glm::distance(curve.at(curve.length() + 0.4), after), 0.02);
  }
}

TEST(BodyCurve, FindsTheNearestOfAllItsPointsFromAnywhereNear) {
  std::mt19937 rng(5);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  for (const auto& points : {kFew, kMany}) {
    const BodyCurve curve(points);
    const Reference<glm::dvec3> reference = through(points);
    std::vector<glm::dvec3> all;
    for (int k = 0; k <= 4000; ++k) all.push_back(reference.at(reference.knot.back() * k / 4000.0));
    int inside = 0;
    for (int i = 0; i < 400; ++i) {
      const glm::dvec3 p =
          all[rng() % all.size()] + 0.5 * glm::dvec3(unit(rng), unit(rng), unit(rng));
      const BodyCurve::Foot foot = curve.nearest(p);
      if (foot.arc <= 0.0 || foot.arc >= curve.length()) continue;
      ++inside;
      double nearest = INFINITY;
      for (const glm::dvec3& each : all) nearest = std::min(nearest, glm::distance(p, each));
      EXPECT_NEAR(glm::distance(p, foot.at), nearest, 1e-4) << i;
      EXPECT_NEAR(glm::dot(p - foot.at, foot.tangent), 0.0, 1e-7) << i;
      EXPECT_NEAR(glm::length(foot.tangent), 1.0, 1e-12);
    }
    EXPECT_GT(inside, 250);
  }
}

TEST(BodyProfile, IsTheSplineThatReachesItsEndsLevel) {
  const std::vector<double> at = {-0.2, 0.1, 0.35, 0.9, 1.4, 1.55},
                            value = {0.3, 0.5, 0.2, 0.45, 0.1, 0.35};
  for (std::size_t count : {2u, 3u, 4u, 6u}) {
    const std::vector<double> places(at.begin(), at.begin() + static_cast<long>(count)),
        values(value.begin(), value.begin() + static_cast<long>(count));
    const BodyProfile profile(places, values);
    const Reference<double> reference(places, values, true);
    for (int k = 0; k <= 60; ++k) {
      const double s = places.front() + (places.back() - places.front()) * k / 60.0;
      double slope = 9.0;
      EXPECT_NEAR(profile(s, &slope), reference.at(s), 1e-12) << count << " " << s;
      EXPECT_NEAR(slope, reference.derivative(s), 1e-11) << count << " " << s;
    }
    for (const double beyond : {0.0, 0.4}) {
      double slope = 9.0;
      EXPECT_EQ(profile(places.front() - beyond, &slope), values.front());
      EXPECT_EQ(slope, 0.0);
      EXPECT_EQ(profile(places.back() + beyond, &slope), values.back());
      EXPECT_EQ(slope, 0.0);
    }
  }
  double slope = 9.0;
  const BodyProfile one({0.5}, {0.25});
  for (const double s : {0.0, 0.5, 1.0}) EXPECT_EQ(one(s, &slope), 0.25);
  EXPECT_EQ(slope, 0.0);
}

}  // namespace
}  // namespace backbend::skin
