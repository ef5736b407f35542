#include "solver/rig/box_solver.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <glm/geometric.hpp>
#include <memory>
#include <random>

#include "solver/curves/box_curve.h"
#include "solver/curves/box_tangents.h"
#include "solver/curves/box_walk.h"
#include "solver/curves/curve.h"
#include "solver/curves/walk.h"
#include "solver/math/box_arc.h"
#include "solver/math/rotation.h"

namespace backbend::solver {
namespace {

const RestChain kStraightUp{{{0, 0, 0}, {0, 2, 0}, {0, 4, 0}, {0, 6, 0}}};
// Bent forward and to the side, as characters' spines are.
const RestChain kBent{{{0, 0, 0}, {0.1, 1.8, 0.5}, {0.2, 3.5, 0.4}, {0.1, 5.6, -0.3}}};

double uniform(std::mt19937& random) { return 2.0 * double(random()) / 4294967296.0 - 1.0; }

/// A random box of three angles, radians, and a random place in it.
struct Box {
  double low[3], high[3];
  BoxReal of[3];

  Box(std::mt19937& random, double reach, double widest) {
    for (int j = 0; j < 3; ++j) {
      const double width = widest * std::abs(uniform(random));
      low[j] = reach * uniform(random);
      high[j] = low[j] + width;
      of[j] = BoxReal::variable(j, low[j], high[j]);
    }
  }
  double at(int j, double y) const {
    return 0.5 * (low[j] + high[j]) + 0.5 * y * (high[j] - low[j]);
  }
};

bool is_inside(const BoxReal& box, double x, double slack = 1e-12) {
  return box.value.lo - slack <= x && x <= box.value.hi + slack;
}

::testing::AssertionResult encloses(const BoxTurn& box, const glm::dquat& q) {
  const double own[] = {q.w, q.x, q.y, q.z};
  const BoxReal* all[] = {&box.w, &box.x, &box.y, &box.z};
  bool as_is = true, negated = true;
  for (int i = 0; i < 4; ++i) {
    as_is = as_is && is_inside(*all[i], own[i]);
    negated = negated && is_inside(*all[i], -own[i]);
  }
  if (as_is || negated) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << "not enclosed";
}

TEST(BoxNumber, EnclosesValuesAndSlopesOfWhatIsCalculated) {
  std::mt19937 random(1);
  for (int i = 0; i < 2000; ++i) {
    const Box box(random, 1.0, 0.5);
    const auto f = [](const auto& x, const auto& y, const auto& z) {
      using std::cos;
      using std::sin;
      const auto a = x * y - z;
      return (a * a + x) / (x * x + y * y + 2.0);
    };
    const BoxReal whole = f(box.of[0], box.of[1], box.of[2]);
    for (int k = 0; k < 5; ++k) {
      double y[3], x[3];
      for (int j = 0; j < 3; ++j) {
        y[j] = 0.99 * uniform(random);
        x[j] = box.at(j, y[j]);
      }
      EXPECT_TRUE(is_inside(whole, f(x[0], x[1], x[2])));
      for (int j = 0; j < 3; ++j) {
        constexpr double kStep = 1e-5;
        double more[] = {x[0], x[1], x[2]};
        more[j] = box.at(j, y[j] + kStep);
        const double slope = (f(more[0], more[1], more[2]) - f(x[0], x[1], x[2])) / kStep;
        EXPECT_GE(slope, whole.slope[j].lo - 1e-4);
        EXPECT_LE(slope, whole.slope[j].hi + 1e-4);
      }
    }
  }
}

TEST(BoxNumber, WidthsFallWithTheSquareOfTheBox) {
  // x (1 - x) - x + x x = 0 has a wide natural enclosure; its mean value form has none to first
  // order.
  double before = 0.0;
  for (const double width : {0.1, 0.01}) {
    const BoxReal x = BoxReal::variable(0, 0.3, 0.3 + width);
    const BoxReal zero = x * (BoxReal(1.0) - x) - x + x * x;
    const double now = zero.value.width();
    if (before > 0.0) {
      EXPECT_LT(now, 0.02 * before);
    }
    before = now;
  }
}

TEST(BoxNumber, TurnsEncloseThoseOfSinglePoses) {
  std::mt19937 random(2);
  int finite = 0;
  for (int i = 0; i < 1000; ++i) {
    const Box box(random, 1.2, 0.2);
    const double t = 0.5 + 0.5 * uniform(random);
    const glm::dquat base = from_euler_xyz(0.3, -0.2, 0.4);
    const BoxTurn turn = from_euler_xyz(box.of[0], box.of[1], box.of[2]);
    const BoxTurn blend = slerp_short(BoxTurn(base), turn, t);
    const glm::dvec3 up(0, 1, 0), aim = glm::normalize(glm::dvec3(1, 0.2, -0.5));
    const BoxTurn arc = shortest_arc(turn * BoxVector(up), BoxVector(aim), BoxVector(up));
    finite += std::isfinite(blend.rate[0]) && std::isfinite(arc.rate[0]);
    for (int k = 0; k < 4; ++k) {
      const glm::dquat q = from_euler_xyz(box.at(0, uniform(random)), box.at(1, uniform(random)),
                                          box.at(2, uniform(random)));
      EXPECT_TRUE(encloses(turn, q));
      if (std::isfinite(blend.rate[0])) {
        EXPECT_TRUE(encloses(blend, slerp_short(base, q, t)));
      }
      if (std::isfinite(arc.rate[0])) {
        EXPECT_TRUE(encloses(arc, shortest_arc(q * up, aim, up)));
      }
    }
  }
  EXPECT_GT(finite, 500);  // few of these boxes hold a pose without an arc
}

TEST(BoxNumber, ASlerpsWeightsAreThoseOfItsFormula) {
  for (const double t : {0.0, 1.0 / 6.0, 0.5, 0.9, 1.0}) {
    for (const double h : {1e-4, 0.01, 0.19, 0.2003, 0.21, 0.8, 1.5}) {
      const double c = std::cos(h);
      const Interval weight = slerp_weight(c, t);
      EXPECT_NEAR(weight.lo, std::sin(t * h) / std::sin(h), 1e-12 + 2e-8 * (h < 1e-3));
      EXPECT_LE(weight.width(), 1e-12);
      constexpr double kStep = 1e-6;
      if (c + kStep > 1.0) continue;
      const double slope =
          (slerp_weight(c + kStep, t).lo - slerp_weight(c - kStep, t).lo) / (2 * kStep);
      EXPECT_NEAR(slerp_weight_slope(c, t).lo, slope, 1e-7);
      EXPECT_LE(slerp_weight_slope(c, t).width(), 1e-10);
    }
  }
  EXPECT_FALSE(slerp_weight(Interval(-0.1, 0.1), 0.5).is_finite());
}

/// Against the turn of a frame that goes with the arc over a small step, about the arc's end.
TEST(BoxNumber, TheRollOfAnArcIsThatOfWhatItCarries) {
  std::mt19937 random(5);
  for (int i = 0; i < 200; ++i) {
    const glm::dvec3 a0(uniform(random), uniform(random), 2.0), a1(uniform(random), 1.0, 0.3),
        b0(uniform(random), 2.0, uniform(random)), b1(0.4, uniform(random), 1.0);
    const auto at = [](const glm::dvec3& from, const glm::dvec3& by, double y) {
      return glm::normalize(from + y * by);
    };
    constexpr double kHalf = 1e-5;
    const BoxReal y = BoxReal::variable(0, -kHalf, kHalf);
    const auto over = [&](const glm::dvec3& from, const glm::dvec3& by) {
      const BoxVector v = BoxVector(from) + y * BoxVector(by);
      return v / length(v);
    };
    const Interval roll = roll_of_arc(over(a0, a1), over(b0, b1))[0];
    // A frame on a that does not roll about it.
    const auto carried = [&](double t) {
      const glm::dvec3 a = at(a0, a1, t);
      const glm::dquat on_a = shortest_arc(at(a0, a1, 0.0), a, kAxisX);
      return shortest_arc(a, at(b0, b1, t), kAxisX) * on_a;
    };
    const glm::dquat turned = carried(kHalf) * glm::conjugate(carried(-kHalf));
    // Twice the vector part over twice the half step.
    const double rolled = std::copysign(1.0, turned.w) *
                          glm::dot(glm::dvec3(turned.x, turned.y, turned.z), at(b0, b1, 0.0));
    EXPECT_NEAR(roll.middle(), rolled, 1e-4 * kHalf + 1e-12) << i;
    EXPECT_LE(roll.width(), 1e-3 * kHalf);
  }
}

bool holds(const Interval& all, double one) {
  return all.lo <= one + 1e-12 && one - 1e-12 <= all.hi;
}

TEST(BoxNumbers, TheArcBetweenTwoDirectionsEnclosesItsRotationVector) {
  const BoxReal y = BoxReal::variable(0, -0.02, 0.02);
  const auto turned = [](double angle, double t) {
    return glm::dvec3(std::cos(angle + 2.0 * t), std::sin(angle + 2.0 * t), 0.0);
  };
  const auto over = [&](double angle) {
    const BoxReal at = BoxReal(angle) + BoxReal(2.0) * y;
    return BoxVector(cosine(at), sine(at), BoxReal(0.0));
  };
  for (const double arc : {0.0, 1e-9, 0.05, 0.8, 1.04, 1.05, 2.0, 2.2}) {
    SCOPED_TRACE(arc);
    const BoxVector between = arc_between(over(0.3), over(0.3 + arc));
    // Both directions turn alike, so the arc stays.
    EXPECT_TRUE(holds(between.z.value, arc)) << between.z.value.lo << " " << between.z.value.hi;
    EXPECT_NEAR(between.z.center.middle(), arc, 1e-14);
    EXPECT_LT(between.z.center.width(), 1e-13);
    const BoxVector from_fixed = arc_between(turned(0.3, 0.0), over(0.3 + arc));
    EXPECT_TRUE(holds(from_fixed.z.slope[0], 2.0 * 0.02)) << from_fixed.z.slope[0].middle();
    if (arc < 0.04) continue;  // its size has a corner at 0
    EXPECT_TRUE(holds(length(from_fixed).value, arc - 0.04));
    EXPECT_TRUE(holds(length(from_fixed).value, arc + 0.04));
    EXPECT_LT(length(from_fixed).value.width(), arc < 1.5 ? 0.12 : 0.4);
  }
  EXPECT_FALSE(arc_between(over(0.0), over(2.5)).is_finite());
}

TEST(BoxArc, EnclosesLengthAndParameterOfEveryCurveOfTheBox) {
  std::mt19937 random(3);
  int finite = 0, narrower = 0;
  for (int i = 0; i < 300; ++i) {
    const Box box(random, 1.0, 0.1);
    const auto points = [](const auto& x, const auto& y, const auto& z, auto vector) {
      return std::array{vector(0.0 * x, 0.0 * x, 0.0 * x), vector(1.0 + 0.2 * x, 0.3 * y, 0.1 * z),
                        vector(1.5 + 0.3 * z, 1.0 + 0.5 * x, 0.4 * y),
                        vector(2.0 + 0.1 * y, 2.0 + x, z)};
    };
    const BoxArc arc(points(
        box.of[0], box.of[1], box.of[2],
        [](const BoxReal& a, const BoxReal& b, const BoxReal& c) { return BoxVector(a, b, c); }));
    const double share = 0.5 + 0.5 * uniform(random);
    const BoxReal u = arc.parameter_at(BoxReal(share) * arc.length());
    const BoxReal of_share = arc.parameter_at_share(share);
    finite += u.is_finite();
    narrower += of_share.value.width() < u.value.width();
    for (int k = 0; k < 4; ++k) {
      const auto curve = Curve::bezier(
          points(box.at(0, uniform(random)), box.at(1, uniform(random)), box.at(2, uniform(random)),
                 [](double a, double b, double c) { return glm::dvec3(a, b, c); }));
      EXPECT_TRUE(is_inside(arc.length(), curve.length(), 1e-11));
      if (u.is_finite()) {
        EXPECT_TRUE(is_inside(u, curve.at_fraction(share).u, 1e-10));
        EXPECT_TRUE(is_inside(of_share, curve.at_fraction(share).u, 1e-10));
      }
    }
  }
  EXPECT_GT(finite, 250);
  EXPECT_GT(narrower, 250);
}

TEST(BoxArc, ACurveThatStandsStillSomewhereHasNoResults) {
  const BoxReal x = BoxReal::variable(0, -0.1, 0.1);
  // Straight there and back: the velocity vanishes at the turn for x = 0.
  const BoxArc arc({BoxVector(0.0, 0.0, 0.0), BoxVector(2.0, x, 0.0), BoxVector(2.0, x, 0.0),
                    BoxVector(0.0, 0.0, 0.0)});
  EXPECT_FALSE(arc.length().is_finite());
  EXPECT_FALSE(arc.parameter_at(BoxReal(0.5)).is_finite());
}

/// The Bezier of a point of the box, and over all of it.
template <class Real, class Vector>
std::array<Vector, 4> bent_curve(const Real& x, const Real& y, const Real& z) {
  return {Vector(0.2 * x, 0.1 * y, 0.0 * z), Vector(1.0 + 0.2 * x, 0.3 * y, 0.1 * z),
          Vector(1.5 + 0.3 * z, 1.0 + 0.5 * x, 0.4 * y), Vector(2.0 + 0.1 * y, 2.0 + x, z)};
}

TEST(BoxWalk, EnclosesTheBonesOfEveryCurveOfTheBox) {
  std::mt19937 random(15);
  int finite = 0, past = 0, narrow = 0;
  for (int i = 0; i < 200; ++i) {
    const Box box(random, 0.6, i % 2 == 0 ? 0.01 : 0.05);
    const BoxWalk walk(bent_curve<BoxReal, BoxVector>(box.of[0], box.of[1], box.of[2]));
    constexpr int kBones = 9;  // a little longer together than the curve
    const auto bone = [](const auto& x) { return 0.4 + 0.05 * x; };
    std::vector<BoxReal> at{BoxReal(0.0)};
    std::vector<BoxVector> way;
    for (int k = 0; k < kBones; ++k) {
      at.push_back(walk.step(at.back(), bone(box.of[0])));
      way.push_back(walk.chord(at[at.size() - 2], at.back()));
    }
    for (int sample = 0; sample < 3; ++sample) {
      double x[3];
      for (int j = 0; j < 3; ++j) x[j] = box.at(j, uniform(random));
      const Curve curve = Curve::bezier(bent_curve<double, glm::dvec3>(x[0], x[1], x[2]));
      Curve::Step before{curve.at_arc(0.0), 0.0};
      for (std::size_t k = 0; k < std::size_t(kBones); ++k) {
        const Curve::Step step =
            curve.step_to_distance(before.place.position, before.arc, bone(x[0]));
        if (at[k + 1].is_finite()) {
          ++finite;
          past += step.arc > curve.length();
          const BoxVector point = walk.point(at[k + 1]);
          narrow += point.x.value.width() < 0.05;
          EXPECT_TRUE(is_inside(point.x, step.place.position.x, 1e-9));
          EXPECT_TRUE(is_inside(point.y, step.place.position.y, 1e-9));
          EXPECT_TRUE(is_inside(point.z, step.place.position.z, 1e-9));
          const glm::dvec3 along = glm::normalize(step.place.position - before.place.position);
          const BoxVector direction = unit(way[k]);
          EXPECT_TRUE(is_inside(direction.x, along.x, 1e-9));
          EXPECT_TRUE(is_inside(direction.y, along.y, 1e-9));
          EXPECT_TRUE(is_inside(direction.z, along.z, 1e-9));
        }
        before = step;
      }
    }
  }
  EXPECT_GT(finite, 2500);
  EXPECT_GT(past, 100);
  EXPECT_GT(narrow, finite / 3);
}

TEST(BoxWalk, ACurveThatTurnsBackHasNoPlace) {
  const BoxReal x = BoxReal::variable(0, -0.01, 0.01);
  const BoxWalk walk({BoxVector(0.0, 0.0, 0.0), BoxVector(2.0, x, 0.0), BoxVector(2.0, 0.3, 0.0),
                      BoxVector(0.0, 0.3, 0.0)});
  EXPECT_TRUE(walk.step(BoxReal(0.0), BoxReal(0.3)).is_finite());
  EXPECT_FALSE(walk.step(BoxReal(0.0), BoxReal(1.7)).is_finite());
}

TEST(BoxCurve, EnclosesPlacesOnEveryPieceAndWhereTheyMeet) {
  std::mt19937 random(16);
  const CurveMap map(CurveMap::Kind::bspline, 5);
  int finite = 0, meeting = 0;
  for (int i = 0; i < 200; ++i) {
    const Box box(random, 0.6, 0.05);
    const auto points = [](const auto& x, const auto& y, const auto& z, auto vector) {
      return std::array{vector(0.0 * x, 0.0 * x, 0.0 * x), vector(0.1 * x, 1.0 + 0.1 * y, 0.0 * z),
                        vector(0.3 * z, 2.0 + 0.2 * x, 0.2 * y),
                        vector(0.2 * y, 3.0 + 0.2 * x, 0.4 * z), vector(x, 4.0 - 0.3 * y, z)};
    };
    const auto own = points(
        box.of[0], box.of[1], box.of[2],
        [](const BoxReal& a, const BoxReal& b, const BoxReal& c) { return BoxVector(a, b, c); });
    const BoxCurve curve(map.draw(std::span<const BoxVector>(own)), 64);
    for (const double share : {0.0, 0.11, 0.3, 0.47, 0.49, 0.5, 0.51, 0.53, 0.8, 1.0}) {
      const BoxVector place = curve.point_at_share(share);
      for (int sample = 0; sample < 3; ++sample) {
        double x[3];
        for (int j = 0; j < 3; ++j) x[j] = box.at(j, uniform(random));
        const Curve plain = map.draw(points(
            x[0], x[1], x[2], [](double a, double b, double c) { return glm::dvec3(a, b, c); }));
        EXPECT_TRUE(is_inside(curve.length(), plain.length(), 1e-11));
        if (!place.is_finite()) continue;
        ++finite;
        const CurvePoint at = plain.at_fraction(share);
        meeting += std::abs(at.u - 0.5) < 0.02;
        EXPECT_TRUE(is_inside(place.x, at.position.x, 1e-10));
        EXPECT_TRUE(is_inside(place.y, at.position.y, 1e-10));
        EXPECT_TRUE(is_inside(place.z, at.position.z, 1e-10));
      }
    }
  }
  EXPECT_GT(finite, 5000);
  EXPECT_GT(meeting, 300);
}

/// Tangents by arc length, their means, and how both move, on curves of one to four pieces.
TEST(BoxTangents, EncloseThoseOfEveryCurveOfTheBox) {
  std::mt19937 random(18);
  int means = 0, places = 0, past = 0, narrow = 0;
  for (int i = 0; i < 120; ++i) {
    const int points = 4 + i % 4;
    const CurveMap map(CurveMap::Kind::bspline, std::size_t(points));
    const Box box(random, 0.6, i % 2 == 0 ? 0.001 : 0.1);
    const auto steps = [&](const auto& x, const auto& y, const auto& z, auto vector) {
      std::vector<decltype(vector(x, y, z))> all;
      for (int k = 0; k + 1 < points; ++k)
        all.push_back(vector(0.1 * k * x, 1.0 + 0.1 * y, 0.2 * k * z));
      return all;
    };
    const auto own = steps(
        box.of[0], box.of[1], box.of[2],
        [](const BoxReal& a, const BoxReal& b, const BoxReal& c) { return BoxVector(a, b, c); });
    const BoxTangents tangents(i % 3 == 0 ? map.legs(own) : bspline_legs(own), 16);
    ASSERT_TRUE(tangents.is_finite());
    // A place that moves along as the pose does.
    const double arc = 0.9 + 0.8 * uniform(random) + (i % 8 == 0 ? double(points) : 0.0);
    BoxSlopes slope;
    for (Interval& s : slope) s = 0.05 * uniform(random);
    double spread = 0.0;
    for (const Interval& s : slope) spread += s.most();
    const BoxTangents::Place place = tangents.at({{arc - spread, arc + spread}, slope, {}});
    const double from = 0.4 + 0.4 * uniform(random), to = from + 0.1;
    const BoxStep mean = tangents.mean_between(from, to);
    ASSERT_TRUE(mean.way.is_finite() && place.tangent.is_finite());
    narrow += mean.way.y.value.width() < 0.02;
    for (int sample = 0; sample < 4; ++sample) {
      double y[3];
      for (double& one : y) one = 0.99 * uniform(random);
      const auto drawn = [&](int j, double shift) {
        double x[3];
        for (int k = 0; k < 3; ++k) x[k] = box.at(k, y[k] + (k == j ? shift : 0.0));
        std::vector<glm::dvec3> point{{0, 0, 0}};
        for (const glm::dvec3& s : steps(x[0], x[1], x[2], [](double a, double b, double c) {
               return glm::dvec3(a, b, c);
             }))
          point.push_back(point.back() + s);
        return map.draw(point);
      };
      const auto mean_of = [&](const Curve& c) {
        return (c.at_fraction(to).position - c.at_fraction(from).position) / (0.1 * c.length());
      };
      const auto arc_at = [&](int j, double shift) {
        double at = arc;
        for (int k = 0; k < 3; ++k) at += slope[k].lo * (y[k] + (k == j ? shift : 0.0));
        return at;
      };
      const Curve plain = drawn(0, 0.0);
      const auto holds = [](const BoxVector& v, const glm::dvec3& p) {
        return is_inside(v.x, p.x, 1e-9) && is_inside(v.y, p.y, 1e-9) && is_inside(v.z, p.z, 1e-9);
      };
      const glm::dvec3 now = mean_of(plain);
      EXPECT_TRUE(is_inside(tangents.length(), plain.length(), 1e-11));
      EXPECT_TRUE(holds(mean.way, now));
      EXPECT_TRUE(holds(place.tangent, plain.at_arc(arc_at(0, 0.0)).tangent));
      const double piece = plain.at_arc(arc_at(0, 0.0)).u * (points - 3);
      EXPECT_TRUE(is_inside(place.piece, piece, 1e-9));
      past += plain.at_arc(arc_at(0, 0.0)).overrun > 0.0;
      for (int j = 0; j < 3; ++j) {
        constexpr double kStep = 1e-4;
        const Curve more = drawn(j, 0.5 * kStep), less = drawn(j, -0.5 * kStep);
        const auto moves = [&](const BoxVector& v, const glm::dvec3& d) {
          const IntervalVector s = v.slope(std::size_t(j));
          constexpr double kSlack = 1e-5;
          return s.x.lo - kSlack <= d.x && d.x <= s.x.hi + kSlack && s.y.lo - kSlack <= d.y &&
                 d.y <= s.y.hi + kSlack && s.z.lo - kSlack <= d.z && d.z <= s.z.hi + kSlack;
        };
        const glm::dvec3 moved = (mean_of(more) - mean_of(less)) / kStep;
        EXPECT_TRUE(moves(mean.way, moved));
        EXPECT_LE(std::abs(glm::dot(now, moved)), mean.lengthening[std::size_t(j)].hi + 1e-5);
        EXPECT_TRUE(moves(place.tangent, (more.at_arc(arc_at(j, 0.5 * kStep)).tangent -
                                          less.at_arc(arc_at(j, -0.5 * kStep)).tangent) /
                                             kStep));
        ++places;
      }
      ++means;
    }
  }
  EXPECT_EQ(means, 480);
  EXPECT_EQ(places, 1440);
  EXPECT_GT(past, 20);
  EXPECT_GT(narrow, 40);
}

/// Few long bones, so that what a walk slides as the pose moves is more than nothing.
TEST(BoxTangents, EncloseTheJointsOfAChainWalkedAlongTheCurve) {
  std::mt19937 random(20);
  int joints = 0, past = 0, slides = 0;
  for (int i = 0; i < 60; ++i) {
    const Box box(random, 0.6, i % 2 == 0 ? 1e-3 : 0.05);
    constexpr std::size_t kSteps = 6;
    const auto steps = [&](const auto& x, const auto& y, const auto& z, auto vector) {
      std::vector<decltype(vector(x, y, z))> all;
      for (std::size_t k = 0; k < kSteps; ++k)
        all.push_back(vector(0.25 * double(k) * x, 1.0 + 0.1 * y, 0.2 * double(k) * z));
      return all;
    };
    const BoxTangents tangents(
        bspline_legs(steps(box.of[0], box.of[1], box.of[2],
                           [](const BoxReal& a, const BoxReal& b, const BoxReal& c) {
                             return BoxVector(a, b, c);
                           })),
        24);
    ASSERT_TRUE(tangents.is_finite());
    const std::vector<double> bone(9, 0.8);
    double y[3];
    for (double& one : y) one = 0.9 * uniform(random);
    const auto laid = [&](int j, double shift) {
      double x[3];
      for (int k = 0; k < 3; ++k) x[k] = box.at(k, y[k] + (k == j ? shift : 0.0));
      std::vector<glm::dvec3> point{{0, 0, 0}}, joint;
      for (const glm::dvec3& s : steps(
               x[0], x[1], x[2], [](double a, double b, double c) { return glm::dvec3(a, b, c); }))
        point.push_back(point.back() + s);
      WalkDetail detail;
      walk_from(Curve::bspline(point), bone, 0.0, joint, &detail);
      return detail.arc;
    };
    const std::vector<double> now = laid(0, 0.0);
    constexpr double kStep = 1e-3;
    std::optional joint = BoxTangents::Joint{};
    for (std::size_t k = 1; k < now.size(); ++k) {
      joint = tangents.walked(*joint, bone[k - 1]);
      ASSERT_TRUE(joint);
      EXPECT_GE(now[k], joint->arc.lo - 1e-10);
      EXPECT_LE(now[k], joint->arc.hi + 1e-10);
      past += now[k] > tangents.length().value.hi;
      ++joints;
      for (int j = 0; j < 3; ++j) {
        const double moved = (laid(j, 0.5 * kStep)[k] - laid(j, -0.5 * kStep)[k]) / kStep;
        const Interval& slope = joint->slope[std::size_t(j)];
        EXPECT_GE(moved, slope.lo - 1e-7);
        EXPECT_LE(moved, slope.hi + 1e-7);
        slides += std::abs(moved) > 1e-5;  // far above what is taken for rounding
      }
    }
  }
  EXPECT_EQ(joints, 540);
  EXPECT_GT(past, 50);
  EXPECT_GT(slides, 200);
  // A bone on which the curve may turn by a radian has no end.
  const auto bent = bspline_legs({{{1, 0, 0}}, {{0.2, 1, 0}}, {{-1, 0.2, 0}}, {{0, -1, 0}}});
  EXPECT_TRUE(BoxTangents(bent, 24).walked({}, 0.05));
  EXPECT_FALSE(BoxTangents(bent, 24).walked({}, 0.3));
}

/// Counts of joints' rates that were held against a box's bounds.
struct Rates {
  int finite = 0, sharp = 0;  // sharp: at least a `near` part of the bound

  /// `a` and `b` are poses of the box, `step` of variable j apart.
  void expect_within(const BoxPose& box, int j, const SpinePose& a, const SpinePose& b, double step,
                     double near) {
    for (std::size_t k = 0; k < box.rate.size(); ++k) {
      const double bound = box.rate[k][std::size_t(j)];
      if (!std::isfinite(bound)) continue;
      const double rate = angle_between(a.turn[k], b.turn[k]) / step;
      EXPECT_LE(rate, bound * (1.0 + 1e-8) + 1e-9) << "joint " << k;
      ++finite;
      sharp += rate > near * bound;
    }
  }
};

TEST(BoxSolvers, ASnakesControlsAreTakenThemselvesToo) {
  std::mt19937 random(19);
  const auto system = build_system({"snake", {{"joints", 30.0}, {"controls", 8.0}}}, kBent);
  const auto& solver = dynamic_cast<const BoxSolver&>(*system);
  EXPECT_EQ(solver.why_fixed("amplitude"), "");
  EXPECT_NE(solver.why_fixed("slide"), "");
  const auto channels = system->channels();
  const auto index = [&](std::string_view name) {
    return std::size_t(std::find_if(channels.begin(), channels.end(),
                                    [&](const Channel& c) { return c.name == name; }) -
                       channels.begin());
  };
  const std::size_t moved[3] = {index("amplitude"), index("frequency"), index("detail.x5")};
  Rates seen;
  for (int i = 0; i < 60; ++i) {
    const double middle[3] = {0.2, 12.0, 0.1}, width[3] = {0.02, 0.4, 0.02};
    double low[3], high[3];
    std::vector<BoxReal> control;
    for (const Channel& c : channels) control.emplace_back(c.rest);
    for (int j = 0; j < 3; ++j) {
      low[j] = middle[j] * (1.0 + 0.8 * uniform(random));
      high[j] = low[j] + width[j];
      control[moved[j]] = BoxReal::variable(j, low[j], high[j]);
    }
    BoxPose pose;
    solver.solve_box(control, pose);
    for (int j = 0; j < 3; ++j) {
      double y[3];
      for (double& one : y) one = 0.9 * uniform(random);
      const auto posed = [&](double shift) {
        std::vector<double> c;
        for (const Channel& channel : channels) c.push_back(channel.rest);
        for (int k = 0; k < 3; ++k) {
          const double at = y[k] + (k == j ? shift : 0.0);
          c[moved[k]] = 0.5 * (low[k] + high[k]) + 0.5 * at * (high[k] - low[k]);
        }
        return system->solve(c);
      };
      constexpr double kStep = 1e-3;
      const SpinePose a = posed(-0.5 * kStep), b = posed(0.5 * kStep);
      seen.expect_within(pose, j, a, b, kStep, 0.5);
    }
  }
  EXPECT_GT(seen.finite, 3000);
  EXPECT_GT(seen.sharp, seen.finite / 6);
}

struct BoxCase {
  const char* name;
  SystemSpec spec;
  double panel = 0.0;  // by how much gains differ on a panel of its curve, which has one bound
};

std::vector<BoxCase> box_cases() {
  using Options = std::map<std::string, OptionValue>;
  return {
      {"three_bone", {"three_bone", {}}},
      {"even", {"even", {}}},
      {"even_anatomical", {"even", Options{{"twist", std::string("anatomical")}, {"bones", 7.0}}}},
      {"neck", {"neck", {}}},
      {"neck_normalised", {"neck", Options{{"gains", std::string("normalised")}}}},
      {"matrix_blend", {"matrix_blend", {}}},
      {"matrix_blend_low", {"matrix_blend", Options{{"bones", 6.0}, {"pivot_pos", 1.0}}}},
      {"matrix_blend_chain", {"matrix_blend", Options{{"pivot_pos", 0.0}}}},
      {"spline_ik", {"spline_ik", {}}},
      {"spline_ik_short", {"spline_ik", Options{{"bones", 3.0}}}},
      {"curve", {"curve", {}}},
      {"curve_interpolating",
       {"curve", Options{{"basis", std::string("interpolate")},
                         {"bones", 7.0},
                         {"length", std::string("arc")},
                         {"arms", std::string("top")}}}},
      {"curve_null_sum", {"curve", Options{{"length", std::string("null_sum")}}}},
      {"curve_rest", {"curve", Options{{"length", std::string("rest")}}}},
      {"snake", {"snake", {}}, 0.1},
      {"snake_short",
       {"snake", Options{{"joints", 40.0}, {"controls", 6.0}, {"twist_u", std::vector{0.3, 0.9}}}},
       0.1},
      {"stretchy", {"stretchy", {}}},
      {"stretchy_kept",
       {"stretchy",
        Options{{"stretchiness", 0.0}, {"bones", 8.0}, {"twist", std::string("spread")}}}},
      {"stretchy_carve", {"stretchy", Options{{"form", std::string("carve")}}}},
      {"stretchy_carve_part",
       {"stretchy", Options{{"form", std::string("carve")}, {"stretchiness", 0.4}}}},
      {"isner", {"isner", {}}},
      {"isner_stretchy",
       {"isner",
        Options{{"length", std::string("stretchy")}, {"placement", std::string("inclusive")}}}},
      {"isner_arc", {"isner", Options{{"aim", std::string("shortest_arc")}}}},
      {"isner_blend", {"isner", Options{{"aim", std::string("none")}}}}};
}

class BoxSolvers : public ::testing::TestWithParam<BoxCase> {};

/// What proofs rest on: no pose of a box turns a joint faster than the box's bound.
TEST_P(BoxSolvers, NoPoseOfABoxOutrunsItsBound) {
  std::mt19937 random(4);
  Rates seen;
  for (const RestChain* chain : {&kStraightUp, &kBent}) {
    const auto system = build_system(GetParam().spec, *chain);
    const auto* solver = dynamic_cast<const BoxSolver*>(system.get());
    ASSERT_NE(solver, nullptr);
    ASSERT_EQ(solver->why_not_on_boxes(), "");
    for (int i = 0; i < 200; ++i) {
      const Mapping mapping = i % 2 == 0 ? Mapping::chest : Mapping::spread;
      const Box box(random, 1.1, i % 4 < 2 ? 0.01 : 0.1);
      BoxPose pose;
      solver->solve_body_box({box.of[0], box.of[1], box.of[2]}, mapping, pose);
      ASSERT_EQ(pose.rate.size(), system->rest().joint_count());
      for (int j = 0; j < 3; ++j) {
        double y[3];
        for (double& one : y) one = 0.9 * uniform(random);
        const auto posed = [&](double shift) {
          double x[3];
          for (int k = 0; k < 3; ++k) x[k] = box.at(k, y[k] + (k == j ? shift : 0.0));
          return system->solve(system->controls_for(
              BodyPose{std::max(x[0], 0.0), std::max(-x[0], 0.0), x[1], x[2], 0.0, 1.0}, mapping));
        };
        constexpr double kStep = 1e-3;
        const SpinePose a = posed(-0.5 * kStep), b = posed(0.5 * kStep);
        seen.expect_within(pose, j, a, b, kStep, 0.8);
      }
    }
  }
  EXPECT_GT(seen.finite, 1000);
  EXPECT_GT(seen.sharp, seen.finite / 6);  // bounds that say something
}

/// What bounds of the skin rest on: at every pose of a box each joint, and what hangs from the
/// spine, is where the box says, and where a pose is known well so is a small box.
TEST_P(BoxSolvers, EveryPoseOfABoxIsInItsPlaces) {
  std::mt19937 random(14);
  int finite = 0, narrow = 0, lengths = 0;
  bool all = false;
  for (const RestChain* chain : {&kStraightUp, &kBent}) {
    const auto system = build_system(GetParam().spec, *chain);
    const auto* solver = dynamic_cast<const BoxSolver*>(system.get());
    if (!solver->why_no_places().empty()) GTEST_SKIP() << solver->why_no_places();
    all = solver->why_no_skin().empty();
    for (int i = 0; i < 60; ++i) {
      const Mapping mapping = i % 2 == 0 ? Mapping::chest : Mapping::spread;
      const Box box(random, 1.1, i % 4 < 2 ? 0.01 : 0.1);
      BoxPlaces places;
      solver->place_box(solver->controls_for(BodyBox{box.of[0], box.of[1], box.of[2]}, mapping),
                        places);
      ASSERT_EQ(places.turn.size(), system->rest().joint_count());
      ASSERT_EQ(places.position.size(), system->rest().joint_count());
      for (int sample = 0; sample < 3; ++sample) {
        double x[3];
        for (int j = 0; j < 3; ++j) x[j] = box.at(j, uniform(random));
        const SpinePose pose = system->solve(system->controls_for(
            BodyPose{std::max(x[0], 0.0), std::max(-x[0], 0.0), x[1], x[2], 0.0, 1.0}, mapping));
        const auto holds = [&](const BoxVector& at, const glm::dvec3& point) {
          if (!at.is_finite()) return;
          ++finite;
          narrow += at.x.value.width() + at.y.value.width() + at.z.value.width() < 0.05;
          EXPECT_TRUE(is_inside(at.x, point.x, 1e-10) && is_inside(at.y, point.y, 1e-10) &&
                      is_inside(at.z, point.z, 1e-10));
        };
        const auto turns = [&](const BoxTurn& turn, const glm::dquat& q) {
          if (turn.w.is_finite()) {
            EXPECT_TRUE(encloses(turn, q));
          }
        };
        for (std::size_t k = 0; k < places.turn.size(); ++k) {
          holds(places.position[k], pose.position[k]);
          turns(places.turn[k], pose.turn[k]);
        }
        if (places.length) {
          double length = 0.0;
          for (std::size_t k = 1; k < pose.position.size(); ++k)
            length += glm::distance(pose.position[k - 1], pose.position[k]);
          EXPECT_TRUE(is_inside(*places.length, length, 1e-10));
          ++lengths;
        }
        holds(places.hip.posed_origin, pose.hip.posed_origin);
        holds(places.chest.posed_origin, pose.chest.posed_origin);
        holds(places.arms.posed_origin, pose.arms.posed_origin);
        turns(places.hip.turn, pose.hip.turn);
        EXPECT_EQ(places.hip.rest_origin, pose.hip.rest_origin);
        turns(places.chest.turn, pose.chest.turn);
        EXPECT_EQ(places.chest.rest_origin, pose.chest.rest_origin);
        turns(places.arms.turn, pose.arms.turn);
        EXPECT_EQ(places.arms.rest_origin, pose.arms.rest_origin);
        if (places.ends_on_chest) {
          EXPECT_LT(glm::distance(pose.position.back(), pose.chest.posed_origin), 1e-12);
        }
        if (places.arms_follow_chest) {
          EXPECT_LT(angle_between(pose.arms.turn, pose.chest.turn), 1e-12);
        }
      }
    }
  }
  EXPECT_GT(all ? finite : 6 * lengths, 2000);
  EXPECT_GE(narrow, finite / 4);
}

/// A box of one pose: the same formulas, so the same gain.
TEST_P(BoxSolvers, ASmallBoxHasTheGainOfItsPose) {
  const auto system = build_system(GetParam().spec, kStraightUp);
  const auto* solver = dynamic_cast<const BoxSolver*>(system.get());
  const double at[3] = {0.5, 0.2, -0.3}, half = 1e-6;
  BoxReal of[3];
  for (int j = 0; j < 3; ++j) of[j] = BoxReal::variable(j, at[j] - half, at[j] + half);
  BoxPose pose;
  solver->solve_body_box({of[0], of[1], of[2]}, Mapping::chest, pose);
  for (int j = 0; j < 3; ++j) {
    double from[3] = {at[0], at[1], at[2]}, to[3] = {at[0], at[1], at[2]};
    from[j] -= half;
    to[j] += half;
    const SpinePose a = system->solve(
        system->controls_for({from[0], 0.0, from[1], from[2], 0.0, 1.0}, Mapping::chest));
    const SpinePose b =
        system->solve(system->controls_for({to[0], 0.0, to[1], to[2], 0.0, 1.0}, Mapping::chest));
    for (std::size_t k = 0; k < pose.rate.size(); ++k) {
      const double gain = angle_between(a.turn[k], b.turn[k]) / (2.0 * half);
      const double bound = pose.rate[k][std::size_t(j)] / half;
      EXPECT_NEAR(bound, gain, 0.02 * gain + 0.02 + GetParam().panel)
          << "joint " << k << " variable " << j;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Solver, BoxSolvers, ::testing::ValuesIn(box_cases()),
                         [](const auto& info) { return std::string(info.param.name); });

TEST(BoxSolvers, EvenReachesTheGainOfItsPaperProofOnAWholeBox) {
  const auto system = build_system({"even", {}}, kBent);
  const auto* solver = dynamic_cast<const BoxSolver*>(system.get());
  const BodyBox turns{BoxReal::variable(0, -12.0, 12.0), BoxReal::variable(1, -12.0, 12.0),
                      BoxReal::variable(2, -12.0, 12.0)};
  BoxPose pose;
  solver->solve_box(solver->controls_for(turns, Mapping::chest), pose);
  for (const BoxRates& rate : pose.rate)
    for (const double each : rate) EXPECT_LE(each, 12.0 * (1.0 + 1e-13));
  for (const double each : pose.rate.back()) EXPECT_GE(each, 12.0);
}

/// Theorem 4 and section 6 of docs/even.md, on boxes of any size; poses stay well below both.
TEST(BoxSolvers, EvenWithReachOrLimitsHasTheGainOfItsTheorem) {
  struct Known {
    SystemSpec spec;
    double bound;
  };
  const Known all[] = {{{"even", {{"limits", std::string("human")}}}, 2.0},
                       {{"even", {{"reach", 0.5}}}, 7.2},
                       {{"even", {{"reach", 1.0}}}, 13.0}};
  std::mt19937 random(9);
  for (const Known& known : all) {
    const auto system = build_system(known.spec, kStraightUp);
    const auto* solver = dynamic_cast<const BoxSolver*>(system.get());
    ASSERT_EQ(solver->why_not_on_boxes(), "");
    double steepest = 0.0;
    for (int i = 0; i < 300; ++i) {
      const Mapping mapping = i % 2 == 0 ? Mapping::chest : Mapping::spread;
      const Box box(random, 1.5, 0.2);
      BoxPose pose;
      solver->solve_box(solver->controls_for(BodyBox{box.of[0], box.of[1], box.of[2]}, mapping),
                        pose);
      for (int j = 0; j < 3; ++j) {
        const double half = 0.5 * (box.at(j, 1.0) - box.at(j, -1.0));
        const auto posed = [&](double shift) {
          double x[3];
          for (int k = 0; k < 3; ++k) x[k] = box.at(k, k == j ? shift : 0.0);
          return system->solve(system->controls_for(
              BodyPose{std::max(x[0], 0.0), std::max(-x[0], 0.0), x[1], x[2], 0.0, 1.0}, mapping));
        };
        constexpr double kStep = 1e-3;
        const SpinePose a = posed(-0.5 * kStep), b = posed(0.5 * kStep);
        for (std::size_t k = 0; k < pose.rate.size(); ++k) {
          const double bound = pose.rate[k][std::size_t(j)];
          EXPECT_LE(bound, known.bound * half * (1.0 + 1e-9));
          const double rate = angle_between(a.turn[k], b.turn[k]) / kStep;
          EXPECT_LE(rate, bound * (1.0 + 1e-8) + 1e-9) << "case " << i << " joint " << k;
          steepest = std::max(steepest, rate / half);
        }
      }
    }
    EXPECT_GT(steepest, 0.9);
  }
}

TEST(BoxSolvers, WhatHasNoIntervalFormSaysSo) {
  const auto why = [](const SystemSpec& spec) {
    const auto system = build_system(spec, kStraightUp);
    return dynamic_cast<const BoxSolver&>(*system).why_not_on_boxes();
  };
  EXPECT_NE(why({"isner", {{"slerp", std::string("raw")}}}).find("raw"), std::string::npos);
  EXPECT_NE(why({"spline_ik", {{"twist", std::string("spread")}}}).find("spread"),
            std::string::npos);
  EXPECT_NE(why({"spline_ik", {{"y_scale_mode", std::string("none")}}}).find("none"),
            std::string::npos);
  EXPECT_NE(why({"spline_ik", {{"resolution_u", 12.0}}}).find("straight"), std::string::npos);
  for (const auto& [option, word] : {std::pair{"basis", "linear"}, std::pair{"follow", "on_curve"},
                                     std::pair{"length", "close"}, std::pair{"roll", "full"}}) {
    EXPECT_NE(why({"curve", {{option, std::string(word)}}}).find(word), std::string::npos);
  }
  EXPECT_NE(why({"stretchy", {{"lead", 0.5}}}).find("lead"), std::string::npos);
  EXPECT_NE(why({"stretchy", {{"form", std::string("carve")}, {"past_end", std::string("extend")}}})
                .find("extend"),
            std::string::npos);
  EXPECT_NE(why({"isner", {{"depth", std::vector<double>{0.0, 0.4}}}}).find("depth"),
            std::string::npos);
}

}  // namespace
}  // namespace backbend::solver
