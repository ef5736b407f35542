#include "solver/curves/curve.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <random>

#include "solver/curves/curve_chain.h"
#include "solver/curves/walk.h"
#include "solver/math/rotation.h"
#include "solver/rig/spine_system.h"

namespace backbend::solver {
namespace {

using glm::dvec3;
using std::vector;

const vector<dvec3> kFive = {{0, 0, 0}, {0.3, 1, 0.2}, {-0.2, 3, 0.9}, {0.5, 5, 0.1}, {0, 6, -1}};

vector<Curve> all_kinds() {
  vector<Curve> list;
  list.push_back(Curve::bezier({dvec3(0, 0, 0), {0, 9, 0}, {3, -3, 5}, {0, 6, 0}}));
  list.push_back(Curve::bspline(kFive));
  list.push_back(Curve::bspline(std::span(kFive).first(3)));
  list.push_back(Curve::bspline(std::span(kFive).first(2)));
  for (const KnotRule rule : {KnotRule::chord, KnotRule::uniform, KnotRule::centripetal}) {
    list.push_back(Curve::interpolating(kFive, make_knots(kFive, rule)));
  }
  list.push_back(Curve::polyline(kFive));
  return list;
}

double brute_length(const Curve& c, int steps) {
  double sum = 0;
  dvec3 before = c.point(0);
  for (int i = 1; i <= steps; ++i) {
    const dvec3 p = c.point(double(i) / steps);
    sum += glm::length(p - before);
    before = p;
  }
  return sum;
}

// ---- shape ----

TEST(Curve, BSplineIsTheDeBoorPointOfItsKnots) {
  // Clamped uniform basis functions by their defining recursion, knots 0 0 0 0 1 2 2 2 2.
  const double knot[] = {0, 0, 0, 0, 1, 2, 2, 2, 2};
  const std::function<double(int, int, double)> basis = [&](int i, int p, double u) -> double {
    if (p == 0) return (u >= knot[i] && u < knot[i + 1]) ? 1.0 : 0.0;
    double sum = 0;
    if (knot[i + p] > knot[i]) sum += (u - knot[i]) / (knot[i + p] - knot[i]) * basis(i, p - 1, u);
    if (knot[i + p + 1] > knot[i + 1]) {
      sum += (knot[i + p + 1] - u) / (knot[i + p + 1] - knot[i + 1]) * basis(i + 1, p - 1, u);
    }
    return sum;
  };
  const Curve c = Curve::bspline(kFive);
  for (double u = 0; u < 1; u += 0.03) {
    dvec3 expected(0);
    for (int i = 0; i < 5; ++i) expected += basis(i, 3, 2 * u) * kFive[std::size_t(i)];
    EXPECT_LT(glm::length(c.point(u) - expected), 1e-14) << u;
  }
}

TEST(Curve, BSplineOfManyPointsIsSmoothInItsSecondDerivative) {
  vector<dvec3> cv;
  for (int i = 0; i < 25; ++i) cv.push_back({std::sin(i * 1.7), i * 1.0, std::cos(i * 2.3)});
  const Curve c = Curve::bspline(cv);
  EXPECT_EQ(c.point(0), cv.front());
  EXPECT_EQ(c.point(1), cv.back());
  for (const CubicPiece& p : c.pieces()) {
    if (p.u1 == 1.0) break;
    EXPECT_LT(glm::length(c.second_derivative(p.u1) - c.second_derivative(p.u1 - 1e-9)), 1e-3);
    EXPECT_LT(glm::length(c.derivative(p.u1) - c.derivative(p.u1 - 1e-12)), 1e-8);
  }
}

TEST(Curve, InterpolatingPassesThroughItsPointsWithContinuousBendAndFreeEnds) {  // R23
  for (const KnotRule rule : {KnotRule::chord, KnotRule::uniform, KnotRule::centripetal}) {
    const auto knot = make_knots(kFive, rule);
    const Curve c = Curve::interpolating(kFive, knot);
    for (std::size_t i = 0; i < 5; ++i) {
      const double u = knot[i] / knot.back();
      EXPECT_LT(glm::length(c.point(u) - kFive[i]), 1e-14);
      if (i == 0 || i == 4) {
        EXPECT_LT(glm::length(c.second_derivative(u)), 1e-9);
        continue;
      }
      EXPECT_LT(degrees(angle_between(c.tangent(u - 1e-9), c.tangent(u))), 1e-6);
      EXPECT_LT(glm::length(c.second_derivative(u - 1e-9) - c.second_derivative(u)), 1e-4);
    }
  }
}

TEST(Curve, KnotsFollowTheirRule) {
  const vector<dvec3> p = {{0, 0, 0}, {0, 4, 0}, {0, 5, 0}};
  EXPECT_EQ(make_knots(p, KnotRule::chord), (vector<double>{0, 4, 5}));
  EXPECT_EQ(make_knots(p, KnotRule::uniform), (vector<double>{0, 1, 2}));
  EXPECT_EQ(make_knots(p, KnotRule::centripetal), (vector<double>{0, 2, 3}));
  EXPECT_THROW(make_knots(vector<dvec3>{{0, 0, 0}, {0, 0, 0}}, KnotRule::uniform), RigError);
  EXPECT_THROW(make_knots(vector<dvec3>{{0, 0, 0}}, KnotRule::chord), RigError);
}

// ---- arc length ----

TEST(Curve, LengthMatchesClosedForms) {  // W16
  EXPECT_DOUBLE_EQ(Curve::polyline(vector<dvec3>{{0, 0, 0}, {3, 4, 0}, {3, 4, 12}}).length(), 17.0);
  // y = x^2 on 0..1 as a Bezier: sqrt(5)/2 + asinh(2)/4.
  const Curve parabola =
      Curve::bezier({dvec3(0, 0, 0), {1.0 / 3, 0, 0}, {2.0 / 3, 1.0 / 3, 0}, {1, 1, 0}});
  EXPECT_NEAR(parabola.length(), std::sqrt(5.0) / 2 + std::asinh(2.0) / 4, 1e-13);
  EXPECT_NEAR(parabola.length(), 1.478942857, 1e-9);
  // A cusp: (t^2, t^3) from -1 to 1 has length 2 (13^(3/2) - 8) / 27.
  const Curve cusp =
      Curve::bezier({dvec3(1, -1, 0), {-1.0 / 3, 1, 0}, {-1.0 / 3, -1, 0}, {1, 1, 0}});
  EXPECT_NEAR(cusp.length(), 2 * (std::pow(13.0, 1.5) - 8) / 27, 1e-9);
}

TEST(Curve, LengthMatchesBruteForce) {
  for (const Curve& c : all_kinds()) {
    const double coarse = brute_length(c, 4000), fine = brute_length(c, 8000);
    const double extrapolated =
        fine + (fine - coarse) / 3;  // the chords' error falls with the square
    EXPECT_NEAR(c.length() / extrapolated, 1.0, 1e-9);
  }
}

/// The Bezier points of a cubic between t0 and t1.
std::array<dvec3, 4> cut(const CubicPiece& whole, double t0, double t1) {
  const double third = (t1 - t0) / 3;
  return {whole.point(t0), whole.point(t0) + third * whole.derivative(t0),
          whole.point(t1) - third * whole.derivative(t1), whole.point(t1)};
}

TEST(Curve, LengthIsTheSumOfItsPartsHoweverTightTheFold) {
  for (const double gap : {1.0, 0.1, 0.01, 1e-3, 1e-5}) {  // from a bow to almost a cusp
    const Curve c = Curve::bezier({dvec3(0, 0, 0), {1 + gap, 1, 0.1}, {-gap, 1, 0}, {1, 0, 0}});
    double sum = 0;
    for (int i = 0; i < 64; ++i) {
      EXPECT_NEAR(c.arc_at(i / 64.0), sum, 1e-12) << gap;
      sum += Curve::bezier(cut(c.pieces()[0], i / 64.0, (i + 1) / 64.0)).length();
    }
    EXPECT_NEAR(c.length(), sum, 1e-12) << gap;
  }
}

TEST(Curve, SeedLengths) {  // research/seeds.md, section 1
  EXPECT_NEAR(Curve::bezier({dvec3(0, 0, 0), {0, 3, 0}, {0, 5, 3}, {0, 4, 7}}).length(), 9.378555,
              5e-7);
  EXPECT_NEAR(Curve::bezier({dvec3(0, 0, 0), {0, 9, 0}, {3, -3, 5}, {0, 6, 0}}).length(), 10.354427,
              5e-7);
}

TEST(Curve, ArcAndParameterAreInverse) {
  for (const Curve& c : all_kinds()) {
    double before = -1;
    for (int i = 0; i <= 200; ++i) {
      const double s = c.length() * i / 200;
      const CurvePoint p = c.at_arc(s);
      EXPECT_NEAR(c.arc_at(p.u), s, 1e-12 * c.length());
      EXPECT_LT(glm::length(c.point(p.u) - p.position), 1e-13);
      EXPECT_GT(p.u, before);
      before = p.u;
      EXPECT_NEAR(glm::length(p.tangent), 1.0, 1e-14);
    }
  }
}

TEST(Curve, PointsAtArcsAreThePlacesBitForBit) {
  for (const Curve& c : all_kinds()) {
    for (const std::size_t count : {2u, 3u, 5u, 6u, 11u, 64u}) {
      const auto point = equal_arc_points(c, count);
      for (std::size_t i = 0; i < count; ++i) {
        EXPECT_EQ(point[i], c.at_arc(c.length() * (double(i) / double(count - 1))).position)
            << i << " of " << count;
      }
    }
  }
}

TEST(CurveMap, DrawsTheCurveThatItsKindDrawsDirectly) {
  const auto knot = make_knots(kFive, KnotRule::centripetal);
  const std::pair<CurveMap, Curve> pairs[] = {
      {CurveMap(CurveMap::Kind::bspline, 5), Curve::bspline(kFive)},
      {CurveMap(CurveMap::Kind::interpolating, 5, knot), Curve::interpolating(kFive, knot)},
      {CurveMap(CurveMap::Kind::polyline, 5), Curve::polyline(kFive)},
  };
  for (const auto& [map, direct] : pairs) {
    const Curve drawn = map.draw(kFive);
    EXPECT_NEAR(drawn.length(), direct.length(), 1e-13);
    for (double u = 0; u <= 1; u += 0.05)
      EXPECT_LT(glm::length(drawn.point(u) - direct.point(u)), 1e-14);
  }
}

TEST(Curve, ContinuesStraightPastBothEnds) {
  for (const Curve& c : all_kinds()) {
    const CurvePoint end = c.at_arc(c.length() + 2.0), start = c.at_arc(-1.5);
    EXPECT_LT(glm::length(end.position - (c.point(1) + 2.0 * c.tangent(1))), 1e-12);
    EXPECT_LT(glm::length(start.position - (c.point(0) - 1.5 * c.tangent(0))), 1e-12);
    EXPECT_NEAR(end.overrun, 2.0, 1e-12);
    EXPECT_EQ(start.overrun, -1.5);
    EXPECT_EQ(end.u, 1.0);
    EXPECT_EQ(start.u, 0.0);
  }
}

TEST(Curve, ScalesBitForBitByPowersOfTwo) {
  for (const double scale : {1.0 / 4096, 0.25, 1024.0}) {
    vector<dvec3> scaled = kFive;
    for (dvec3& p : scaled) p *= scale;
    const Curve a = Curve::bspline(kFive), b = Curve::bspline(scaled);
    EXPECT_EQ(b.length(), scale * a.length());
    for (int i = 0; i <= 50; ++i)
      EXPECT_EQ(b.at_fraction(i / 50.0).position, scale * a.at_fraction(i / 50.0).position);
  }
}

// ---- degenerate curves ----

TEST(Curve, TangentWhereTheDerivativeVanishes) {
  // Doubled end points: the curve leaves toward, and arrives from, the next distinct one.
  const Curve c = Curve::bezier({dvec3(0, 0, 0), {0, 0, 0}, {1, 0, 0}, {1, 0, 0}});
  EXPECT_EQ(c.tangent(0), dvec3(1, 0, 0));
  EXPECT_EQ(c.tangent(1), dvec3(1, 0, 0));
  const Curve triple = Curve::bezier({dvec3(0, 0, 0), {0, 0, 0}, {0, 0, 0}, {0, 0, 2}});
  EXPECT_EQ(triple.tangent(0), dvec3(0, 0, 1));
  const Curve late = Curve::polyline(vector<dvec3>{{0, 0, 0}, {0, 0, 0}, {0, 1, 0}});
  EXPECT_EQ(late.tangent(0), dvec3(0, 1, 0));
}

TEST(Curve, ACurveThatIsOnePointIsFinite) {
  const dvec3 p(1, 2, 3);
  const Curve c = Curve::bezier({p, p, p, p});
  EXPECT_EQ(c.length(), 0.0);
  EXPECT_EQ(c.tangent(0.3), dvec3(0));
  EXPECT_EQ(c.at_arc(0.0).position, p);
  EXPECT_EQ(c.at_arc(5.0).position, p);  // no direction to run on in
  EXPECT_EQ(c.at_fraction(0.5).position, p);
  EXPECT_EQ(c.step_to_distance(p, 0.0, 1.0).place.position, p);  // and ends
}

// ---- walking and closest points ----

TEST(Walk, ABoneThatMeetsTheCurveSquareToItHasNoMarginLeft) {
  // An arch whose top is at most `reach` from its foot: a bone longer than that passes it by.
  const Curve arch = Curve::bezier({dvec3(0, 0, 0), {0, 4, 0}, {3, 4, 0}, {1, 0, 0}});
  double top = 0.0, reach = 0.0;
  for (int i = 0; i <= 100000; ++i) {
    const double distance = glm::length(arch.point(i / 100000.0));
    if (distance > reach) reach = distance, top = i / 100000.0;
  }
  ASSERT_GT(top, 0.1);
  ASSERT_LT(top, 0.9);
  vector<dvec3> joint;
  WalkDetail detail;
  double before = 4.0;
  for (const double share : {0.5, 0.99, 0.9999, 0.99999}) {
    walk_from(arch, vector<double>{share * reach, 0.01 * reach}, 0.0, joint, &detail);
    EXPECT_EQ(detail.margin[0], kPi);
    EXPECT_LT(detail.margin[1], before) << share;
    EXPECT_LE(detail.margin[2], detail.margin[1]) << "what comes after inherits it";
    before = detail.margin[1];
  }
  EXPECT_LT(before, 5e-3);
  walk_from(arch, vector<double>{1.01 * reach}, 0.0, joint, &detail);
  EXPECT_GT(detail.arc[1], arch.length()) << "it is past the end now";
}

TEST(Curve, StepsMeetTheDistanceAtTheFirstPlace) {
  for (const Curve& c : all_kinds()) {
    for (double from = 0; from < c.length(); from += c.length() / 7) {
      const dvec3 centre = c.at_arc(from).position;
      const double distance = c.length() / 9;
      const Curve::Step step = c.step_to_distance(centre, from, distance);
      EXPECT_NEAR(glm::length(step.place.position - centre), distance, 1e-12);
      for (int i = 1; i < 200; ++i) {  // nothing before it is as far away
        const double arc = from + (step.arc - from) * i / 200;
        EXPECT_LT(glm::length(c.at_arc(arc).position - centre), distance + 1e-9);
      }
    }
  }
}

TEST(Curve, StepsRunStraightPastTheEnd) {
  for (const Curve& c : all_kinds()) {
    const double from = 0.97 * c.length();
    const dvec3 centre = c.at_arc(from).position;
    for (const double distance : {0.1 * c.length(), 3.0 * c.length()}) {
      const Curve::Step step = c.step_to_distance(centre, from, distance);
      EXPECT_NEAR(glm::length(step.place.position - centre), distance, 1e-12 * c.length());
      EXPECT_GT(step.place.overrun, 0.0);
      const Curve::Step next = c.step_to_distance(step.place.position, step.arc, distance);
      EXPECT_NEAR(next.arc - step.arc, distance, 1e-12 * c.length());
    }
  }
}

TEST(Curve, StepsGetOutOfATightFold) {
  // A hairpin: the curve comes back past its start before it is `distance` away.
  const Curve c = Curve::bezier({dvec3(0, 0, 0), {0, 1, 0}, {0.1, 1, 0}, {0.1, -4, 0}});
  const Curve::Step step = c.step_to_distance({0, 0, 0}, 0.0, 1.2);
  EXPECT_NEAR(glm::length(step.place.position), 1.2, 1e-12);
  EXPECT_LT(step.place.position.y, 0.0);
}

TEST(Curve, ClosestPointBeatsEverySample) {
  std::mt19937 rng(7);
  std::uniform_real_distribution<double> box(-3, 8);
  for (const Curve& c : all_kinds()) {
    for (int k = 0; k < 20; ++k) {
      const dvec3 p(box(rng), box(rng), box(rng));
      const double found = glm::length(c.point(c.closest_parameter(p)) - p);
      for (int i = 0; i <= 1000; ++i)
        EXPECT_LE(found, glm::length(c.point(i / 1000.0) - p) + 1e-12);
    }
  }
}

// ---- length nulls ----

/// A semicircle of radius 1 as 64 Bezier arcs is beyond the tests' tolerance; the nulls only need
/// points on it, so a fine polyline serves.
Curve semicircle() {
  vector<dvec3> p;
  for (int i = 0; i <= 20000; ++i)
    p.push_back({0, std::sin(kPi * i / 20000), 1 - std::cos(kPi * i / 20000)});
  return Curve::polyline(p);
}

TEST(NullLength, OfASemicircleIsThatOfNineChords) {  // R34, R36, R37
  const Curve c = semicircle();
  const double nine = 18 * std::sin(radians(10));  // 3.125667: half a percent short of pi
  EXPECT_NEAR(length_by_first_null(c), nine, 1e-6);
  EXPECT_NEAR(length_by_null_sum(c), nine, 1e-6);  // constant curvature: all gaps agree
  EXPECT_NEAR(length_by_first_null(c) / 10, 0.312567, 1e-6);
}

TEST(NullLength, ClosingASemicircleTakesTheChordOfNineTurns) {  // R155
  const Curve c = semicircle();
  CurveChain chain;
  lay_chain(c, 10, Follow::on_curve, BoneLength::close, c.length(), chain);
  EXPECT_NEAR(chain.bone_length, 2 * std::sin(radians(9)), 1e-6);
  EXPECT_LT(glm::length(chain.joint.back() - c.point(1)), 1e-9);
  lay_chain(c, 10, Follow::on_curve, BoneLength::nulls, c.length(), chain);
  EXPECT_NEAR(glm::length(chain.joint.back() - c.point(1)), 0.00306, 1e-5);
  lay_chain(c, 10, Follow::on_curve, BoneLength::arc, c.length(), chain);
  EXPECT_NEAR(chain.overrun, radians(0.749), 2e-4);
}

}  // namespace
}  // namespace backbend::solver
