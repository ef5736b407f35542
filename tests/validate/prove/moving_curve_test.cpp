#include "validate/prove/moving_curve.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <vector>

#include "solver/curves/curve.h"
#include "solver/math/rotation.h"

namespace backbend::validate {
namespace {

using glm::dvec3;
using solver::Interval;

constexpr int kPieces = 4;
constexpr double kBone = 0.6;

/// What the two channels of the test's curve do to its steps: extension turns each about X by a
/// growing share, side about a Y that leans.
struct Body {
  static const std::vector<dvec3>& rest() {
    static const std::vector<dvec3> step = {{0.1, 1, 0},      {0, 0.8, 0.2}, {-0.2, 1.1, 0.1},
                                            {0.1, 0.9, -0.2}, {0, 1, 0.1},   {0.1, 0.7, 0.1}};
    return step;
  }
  static double share(std::size_t i) { return double(i) / double(rest().size() - 1); }

  static std::vector<MovingVector> over(const MovingChannels& channels) {
    std::vector<MovingVector> step;
    for (std::size_t i = 0; i < rest().size(); ++i) {
      const Interval part(share(i));
      const MovingVector bent = turned(MovingVector(fixed(rest()[i])), 0, part * channels.angle[0]);
      step.push_back(turned(bent, 2, part * channels.angle[1]));
    }
    return step;
  }
  static solver::Curve at(double extension, double side) {
    std::vector<dvec3> point{{0, 0, 0}};
    for (std::size_t i = 0; i < rest().size(); ++i) {
      const auto by = [&](double degrees, const dvec3& axis) {
        return solver::turn_about(axis, solver::radians(share(i) * degrees));
      };
      point.push_back(point.back() + by(side, {0, 0, 1}) * (by(extension, {1, 0, 0}) * rest()[i]));
    }
    return solver::Curve::bspline(point);
  }
};

SubBox part_of(double extension, double side, double width) {
  SubBox box;
  box.low = {extension - 0.5 * width, side - 0.5 * width, 0.0};
  box.high = {extension + 0.5 * width, side + 0.5 * width, 0.0};
  return box;
}

struct Laid {
  std::vector<MovingCurve::Place> share, walked;
  MovingNumber length;
  std::vector<MovingVector> way;  // between the shares
};
Laid laid(const SubBox& part, int panels = 128) {
  const MovingChannels channels(part);
  const MovingCurve curve(Body::over(channels), channels.reach, panels);
  Laid out;
  out.length = curve.length();
  MovingCurve::Place from = curve.start(), joint = curve.start();
  const glm::dmat3 axes(1.0);
  for (int k = 1; k <= 5; ++k) {
    const auto to = curve.share(k, 5);
    const auto next =
        curve.step(joint, Interval(kBone), axes_along(curve.velocity_about(joint), axes));
    if (!to || !next) return {};
    out.way.push_back(curve.way(from, *to, Interval(1.0) / Interval(5) * out.length, axes));
    out.share.push_back(*to);
    out.walked.push_back(*next);
    from = *to;
    joint = *next;
  }
  return out;
}

const double kPoses[][2] = {{0, 0}, {40, 10}, {-70, 30}, {110, -50}};

TEST(MovingCurve, HasTheLengthsPlacesAndStepsOfTheSolversCurve) {
  for (const auto& [extension, side] : kPoses) {
    const Laid found = laid(part_of(extension, side, 1e-7));
    const solver::Curve curve = Body::at(extension, side);
    ASSERT_EQ(found.share.size(), 5u) << extension;
    EXPECT_NEAR(found.length.value.middle(), curve.length(), 1e-5);
    EXPECT_LT(found.length.value.width(), 1e-3);
    dvec3 before(0.0);
    double walked_arc = 0.0;
    dvec3 walked(0.0);
    for (int k = 1; k <= 5; ++k) {
      const solver::CurvePoint place = curve.at_fraction(0.2 * k);
      const auto& mine = found.share[std::size_t(k - 1)];
      EXPECT_NEAR(mine.u.value.middle(), kPieces * place.u, 1e-5);
      EXPECT_LT(
          glm::distance(middle_of(found.way[std::size_t(k - 1)].value), place.position - before),
          1e-5);
      before = place.position;
      const auto step = curve.step_to_distance(walked, walked_arc, kBone);
      EXPECT_NEAR(found.walked[std::size_t(k - 1)].u.value.middle(), kPieces * step.place.u, 1e-6);
      walked_arc = step.arc;
      walked = step.place.position;
    }
  }
}

TEST(MovingCurve, ItsDerivativesAreThoseOfTheSolversCurve) {
  constexpr double kStep = 0.01;  // degrees
  const double per_radian = 0.5 / solver::radians(kStep);
  for (const auto& [extension, side] : kPoses) {
    const Laid found = laid(part_of(extension, side, 1e-7), 512);
    for (std::size_t j = 0; j < 2; ++j) {
      const double de = j == 0 ? kStep : 0.0, ds = j == 1 ? kStep : 0.0;
      const solver::Curve less = Body::at(extension - de, side - ds),
                          more = Body::at(extension + de, side + ds);
      const auto expect = [&](const Interval& slope, double low, double high) {
        EXPECT_LT(slope.width(), 0.02);
        EXPECT_NEAR(slope.middle(), (high - low) * per_radian, 2e-3);
      };
      expect(found.length.by[j], less.length(), more.length());
      dvec3 less_before(0.0), more_before(0.0);
      struct Walker {
        dvec3 at{0.0};
        double arc = 0.0;
        double go(const solver::Curve& curve) {
          const auto step = curve.step_to_distance(at, arc, kBone);
          at = step.place.position;
          arc = step.arc;
          return kPieces * step.place.u;
        }
      } less_walker, more_walker;
      for (int k = 1; k <= 5; ++k) {
        const auto low = less.at_fraction(0.2 * k), high = more.at_fraction(0.2 * k);
        expect(found.share[std::size_t(k - 1)].u.by[j], kPieces * low.u, kPieces * high.u);
        for (int i = 0; i < 3; ++i) {
          expect(found.way[std::size_t(k - 1)].by[j][std::size_t(i)],
                 low.position[i] - less_before[i], high.position[i] - more_before[i]);
        }
        less_before = low.position;
        more_before = high.position;
        expect(found.walked[std::size_t(k - 1)].u.by[j], less_walker.go(less),
               more_walker.go(more));
      }
    }
  }
}

/// Over a part as wide as checks bound at once, all that the solver's curve has at its poses.
TEST(MovingCurve, EnclosesEveryPoseOfAPart) {
  for (const auto& [extension, side] : kPoses) {
    const Laid found = laid(part_of(extension, side, 1.0), 32);
    ASSERT_EQ(found.share.size(), 5u) << extension;
    for (const double e : {-0.5, -0.2, 0.37, 0.5}) {
      for (const double s : {-0.5, 0.1, 0.5}) {
        const solver::Curve curve = Body::at(extension + e, side + s);
        EXPECT_TRUE(found.length.value.holds(curve.length()));
        dvec3 before(0.0), walked(0.0);
        double arc = 0.0;
        for (std::size_t k = 0; k < 5; ++k) {
          const auto place = curve.at_fraction(0.2 * double(k + 1));
          EXPECT_LE(found.share[k].u.value.lo, kPieces * place.u + 1e-9);
          EXPECT_GE(found.share[k].u.value.hi, kPieces * place.u - 1e-9);
          for (int i = 0; i < 3; ++i) {
            EXPECT_LE(found.way[k].value[std::size_t(i)].lo, place.position[i] - before[i] + 1e-9);
            EXPECT_GE(found.way[k].value[std::size_t(i)].hi, place.position[i] - before[i] - 1e-9);
          }
          before = place.position;
          const auto step = curve.step_to_distance(walked, arc, kBone);
          EXPECT_TRUE(found.walked[k].u.value.holds(kPieces * step.place.u));
          walked = step.place.position;
          arc = step.arc;
        }
      }
    }
  }
}

/// With few panels slopes are loose, and hold the true ones still.
TEST(MovingCurve, EnclosesSlopesOnFewPanels) {
  constexpr double kStep = 0.01;
  for (const auto& [extension, side] : kPoses) {
    const MovingChannels channels(part_of(extension, side, 1e-9));
    const MovingCurve curve(Body::over(channels), channels.reach, 1);
    const double rise =
        (Body::at(extension + kStep, side).length() - Body::at(extension - kStep, side).length()) *
        0.5 / solver::radians(kStep);
    const Interval slope = curve.length().by[0];
    EXPECT_LE(slope.lo, rise + 1e-6) << extension;
    EXPECT_GE(slope.hi, rise - 1e-6) << extension;
    EXPECT_GT(slope.width(), 1e-3) << extension;
  }
}

/// Behind a hairpin the distance falls again, and the first place at one is not told from others.
TEST(MovingCurve, WalksNoBoneThatTheCurveTurnsFarUnder) {
  const auto fixed_step = [](double x, double y) { return MovingVector(Vec{x, y, 0.0}); };
  const MovingCurve hairpin({fixed_step(0, 1), fixed_step(0, 1), fixed_step(0.3, 0.1),
                             fixed_step(0, -1), fixed_step(0, -1)},
                            Reach{}, 16);
  const glm::dmat3 axes = axes_along({0, 1, 0}, glm::dmat3(1.0));
  EXPECT_TRUE(hairpin.step(hairpin.start(), Interval(0.8), axes));
  const auto near_top = hairpin.place_at(Interval(0.45) * hairpin.length());
  ASSERT_TRUE(near_top);
  EXPECT_FALSE(hairpin.step(*near_top, Interval(0.5), axes));
}

TEST(MovingCurve, GoesStraightOnPastItsEnd) {
  const MovingChannels channels(part_of(20, 10, 0.5));
  const MovingCurve curve(Body::over(channels), channels.reach, 32);
  const solver::Curve plain = Body::at(20, 10);
  const glm::dmat3 axes(1.0);
  const auto near_end = curve.place_at(Interval(0.95) * curve.length());
  ASSERT_TRUE(near_end);
  const auto over = curve.step(*near_end, Interval(1.0), axes);
  ASSERT_TRUE(over);
  EXPECT_GT(over->u.value.lo, double(kPieces));
  const dvec3 from = plain.at_fraction(0.95).position;
  const auto step = plain.step_to_distance(from, 0.95 * plain.length(), 1.0);
  EXPECT_LT(
      glm::distance(middle_of(curve.way(*near_end, *over, axes).value), step.place.position - from),
      1e-3);
}

TEST(MovingFrame, TurnsAsFastAsFramesThatAreCarriedByTheShortestArc) {
  const auto carried = [](double extension, double side) {
    const solver::Curve curve = Body::at(extension, side);
    std::vector<dvec3> direction;
    dvec3 before(0.0);
    for (int k = 1; k <= 5; ++k) {
      direction.push_back(glm::normalize(curve.at_fraction(0.2 * k).position - before));
      before = curve.at_fraction(0.2 * k).position;
    }
    std::vector<glm::dquat> frame(direction.size());
    solver::transport_along(glm::dquat(1, 0, 0, 0), direction, frame);
    return frame;
  };
  constexpr double kStep = 0.01;
  for (const auto& [extension, side] : kPoses) {
    const SubBox part = part_of(extension, side, 1e-7);
    const Laid found = laid(part, 512);
    MovingFrame frame({1, 0, 0}, MovingChannels(part).reach);
    glm::dmat3 axes(1.0);
    for (std::size_t k = 0; k < 5; ++k) {
      axes = axes_along(middle_of(found.way[k].center), axes);
      ASSERT_TRUE(frame.go(axes, on_axes(axes, found.way[k])));
      for (std::size_t j = 0; j < 2; ++j) {
        const double de = j == 0 ? kStep : 0.0, ds = j == 1 ? kStep : 0.0;
        const glm::dquat less = carried(extension - de, side - ds)[k],
                         more = carried(extension + de, side + ds)[k];
        const double rate = 2.0 *
                            std::asin(glm::length(dvec3((more * glm::conjugate(less)).x,
                                                        (more * glm::conjugate(less)).y,
                                                        (more * glm::conjugate(less)).z))) /
                            solver::radians(2.0 * kStep);
        const Interval bound = frame.rate(j, 0.0);
        EXPECT_GE(bound.hi, rate - 1e-6) << extension << " bone " << k;
        EXPECT_LE(bound.lo, rate + 1e-6) << extension << " bone " << k;
        EXPECT_LT(bound.width(), 0.1) << extension << " bone " << k;
      }
    }
  }
}

TEST(MovingFrame, KnowsNoArcBetweenOppositeBones) {
  MovingFrame frame({1, 0, 0}, Reach{});
  EXPECT_TRUE(frame.go(glm::dmat3(1.0), MovingVector(Vec{0.1, 1.0, 0.0})));
  EXPECT_FALSE(frame.go(glm::dmat3(1.0), MovingVector(Vec{-0.1, -1.0, 0.05})));
}

}  // namespace
}  // namespace backbend::validate
