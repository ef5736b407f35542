#include "validate/metrics/chain/bend_shares.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/gtc/quaternion.hpp>

#include "validate/metrics/math/rotation.h"

namespace backbend::validate {
namespace {

constexpr std::size_t kJoints = 5, kFrames = 61;

/// A backbend of two degrees a frame, shared by five joints; `uneven` gives the upper ones more.
std::vector<glm::dvec3> sweep(double uneven = 0.0) {
  std::vector<glm::dvec3> out;
  for (std::size_t f = 0; f < kFrames; ++f)
    for (std::size_t k = 0; k < kJoints; ++k)
      out.emplace_back(radians_from(-0.4 * static_cast<double>(f) *
                                    (1.0 + uneven * (static_cast<double>(k) - 2.0))),
                       0.0, 0.0);
  return out;
}

ShareExcess worst(const std::vector<glm::dvec3>& turn, bool from_rest = true) {
  const std::vector<ShareExcess> all = share_excess(turn, kJoints, from_rest);
  return *std::max_element(all.begin(), all.end(), [](const ShareExcess& a, const ShareExcess& b) {
    return a.deg - a.limit_deg < b.deg - b.limit_deg;
  });
}

TEST(ShareExcess, NoRigIsBlamedForAnUnevenBend) {
  for (const double uneven : {0.0, 0.1, 0.25, 0.4}) EXPECT_LT(worst(sweep(uneven)).deg, 1e-6);
}

TEST(ShareExcess, AKinkIsFoundAtItsJointByItsSizeWhereverItBegins) {
  for (const double size_deg : {10.0, 30.0})
    for (const std::size_t from : {0u, 35u, 50u})
      for (const glm::dvec3& axis : {glm::dvec3(1, 0, 0), glm::dvec3(0, 1, 0)}) {
        std::vector<glm::dvec3> turn = sweep();
        for (std::size_t f = from; f < kFrames; ++f)
          turn[f * kJoints + 3] = rotation_vector(rotation(turn[f * kJoints + 3]) *
                                                  rotation(axis * radians_from(size_deg)));
        const ShareExcess found = worst(turn);
        EXPECT_EQ(found.joint, 3) << size_deg << " from " << from;
        EXPECT_NEAR(found.deg, size_deg, 0.02 * size_deg) << from;
        EXPECT_GT(found.deg, found.limit_deg);
        EXPECT_GT(glm::dot(glm::normalize(found.turn), axis),
                  0.9);  // the bend turns it by up to 24 deg
      }
}

/// A sweep to a corner of three channels, each of whose turns every joint has its part of, one
/// after the other: joint k of the chain is turned from rest by the product of part[k] of each.
std::vector<glm::dvec3> corner(const glm::dvec3& end_deg, std::size_t frames) {
  const double part[] = {0.0, 0.0, 0.24, 0.48, 0.68, 1.0};  // `even` on a MakeHuman spine
  std::vector<glm::dvec3> out;
  for (std::size_t f = 0; f < frames; ++f) {
    const glm::dvec3 at = static_cast<double>(f) / static_cast<double>(frames - 1) * end_deg;
    const auto turned = [&](double share) {
      const auto about = [&](int axis) {
        glm::dvec3 turn(0.0);
        turn[axis] = radians_from(share * at[axis]);
        return rotation(turn);
      };
      return about(0) * about(2) * about(1);
    };
    for (std::size_t k = 0; k < kJoints; ++k)
      out.push_back(rotation_vector(glm::conjugate(turned(part[k])) * turned(part[k + 1])));
  }
  return out;
}

TEST(ShareExcess, NoRigIsBlamedForSharesThatAWidePoseBends) {
  for (const std::size_t frames : {11u, 61u})
    for (const glm::dvec3& end : {glm::dvec3(90, 60, 45), glm::dvec3(90, -60, -45),
                                  glm::dvec3(-120, 60, 45), glm::dvec3(-60, 90, -45)}) {
      const ShareExcess found = worst(corner(end, frames));
      EXPECT_LT(found.deg, found.limit_deg) << frames;
    }
}

TEST(ShareExcess, AKinkInAWidePoseIsFound) {
  for (const std::size_t frames : {11u, 61u})
    for (const std::size_t from : {1u, 6u, 8u}) {  // tenths of the sweep
      std::vector<glm::dvec3> turn = corner({90, 60, 45}, frames);
      for (std::size_t f = from * (frames - 1) / 10; f < frames; ++f) {
        glm::dvec3& at = turn[f * kJoints + 2];
        at = rotation_vector(rotation(at) * rotation(glm::dvec3(radians_from(25.0), 0.0, 0.0)));
      }
      const ShareExcess found = worst(turn);
      EXPECT_EQ(found.joint, 2) << from;
      EXPECT_GT(found.deg, found.limit_deg) << from;
    }
}

TEST(ShareExcess, PostureThatIsHeldIsNoKinkOfCapturedMotion) {
  std::vector<glm::dvec3> turn = sweep();
  for (std::size_t f = 0; f < kFrames; ++f) turn[f * kJoints + 3].x += radians_from(20.0);
  EXPECT_LT(worst(turn, false).deg, 1e-6);
}

TEST(ShareExcess, JointsThatKeepNoSharesRaiseTheLimit) {
  std::vector<glm::dvec3> turn = sweep();
  for (std::size_t f = 0; f < kFrames; ++f)
    turn[f * kJoints + 1].x += radians_from(10.0 * std::sin(0.3 * static_cast<double>(f)));
  const ShareExcess found = worst(turn);
  EXPECT_LT(found.deg, found.limit_deg);
}

TEST(ShareExcess, TwoJointsAndFourFramesTellNothing) {
  EXPECT_EQ(share_excess(std::vector<glm::dvec3>(20), 2, true).front().deg, 0.0);
  EXPECT_EQ(share_excess(std::vector<glm::dvec3>(20), 5, true).front().deg, 0.0);
}

const glm::dmat3 kAxes(1.0);  // left, up, forward

ShareExcess worst_counter(const std::vector<glm::dvec3>& turn, const glm::dmat3& axes = kAxes,
                          const MotionFacts& facts = {}) {
  const std::vector<ShareExcess> all = counter_turns(turn, kJoints, axes, facts);
  return *std::max_element(all.begin(), all.end(), [](const ShareExcess& a, const ShareExcess& b) {
    return a.deg - a.limit_deg < b.deg - b.limit_deg;
  });
}

/// A sweep to 24 degrees in which joint 2 turns by `deg` about the axis, growing with the sweep,
/// and joint 3 turns back.
std::vector<glm::dvec3> taken_back(double deg, const glm::dvec3& axis) {
  std::vector<glm::dvec3> turn = sweep();
  for (std::size_t f = 0; f < kFrames; ++f) {
    const double t = static_cast<double>(f) / (kFrames - 1);
    for (std::size_t k = 0; k < kJoints; ++k) turn[f * kJoints + k] *= 0.2;
    turn[f * kJoints + 2] += axis * radians_from(deg * t);
    turn[f * kJoints + 3] -= axis * radians_from(deg * t);
  }
  return turn;
}

TEST(CounterTurns, NoRigIsBlamedForAnUnevenBend) {
  for (const double uneven : {0.0, 0.1, 0.25, 0.4})
    EXPECT_LT(worst_counter(sweep(uneven)).deg, 1e-6);
}

TEST(CounterTurns, AKinkOrRollThatGrowsWithTheSweepIsFoundByItsSize) {
  for (const double size_deg : {15.0, 40.0})
    for (const glm::dvec3& axis :
         {glm::dvec3(0, 1, 0), glm::dvec3(0, 0, 1), glm::dvec3(0, -1, 0)}) {
      const ShareExcess found = worst_counter(taken_back(size_deg, axis));
      EXPECT_TRUE(found.joint == 2 || found.joint == 3);
      EXPECT_NEAR(found.deg, size_deg, 1e-6);
      EXPECT_GT(found.deg, found.limit_deg);
      EXPECT_EQ(found.beyond, ShareExcess::Beyond::whole);
      EXPECT_NEAR(std::abs(glm::dot(glm::normalize(found.turn), axis)), 1.0, 1e-9);
    }
  // share_excess() takes it for the joint's own share.
  EXPECT_LT(worst(taken_back(15.0, {0, 1, 0})).deg, 1e-6);
}

TEST(CounterTurns, AreTheSameForABodyThatStandsTurned) {
  const glm::dmat3 axes = glm::mat3_cast(rotation(glm::dvec3(0.3, 0.8, -0.2)));
  std::vector<glm::dvec3> turn = taken_back(15.0, {0, 1, 0});
  const ShareExcess straight = worst_counter(turn);
  for (glm::dvec3& each : turn) each = axes * each;
  const ShareExcess turned = worst_counter(turn, axes);
  EXPECT_EQ(turned.joint, straight.joint);
  EXPECT_NEAR(turned.deg, straight.deg, 1e-9);
  EXPECT_NEAR(glm::distance(turned.turn, axes * straight.turn), 0.0, 1e-9);
}

TEST(CounterTurns, OneAxisThatBringsAnotherWithItIsNoKink) {
  // 0.4 of the bend, as splines along a curved spine have it.
  const ShareExcess last =
      counter_turns(taken_back(0.4 * 24.0, {0, 1, 0}), kJoints, kAxes, {}).back();
  EXPECT_NEAR(last.deg, 9.6, 1e-6);
  EXPECT_NEAR(last.limit_deg, 10.8, 1e-6);
}

TEST(CounterTurns, ASmallRollInABendIsFoundWhereBothSidesAreAlike) {
  // Too small beside a bend of 24 degrees for a spine of which nothing is known.
  const std::vector<glm::dvec3> turn = taken_back(10.0, {0, 1, 0});
  const ShareExcess unknown = worst_counter(turn);
  EXPECT_LE(unknown.deg, unknown.limit_deg);
  const ShareExcess found = worst_counter(turn, kAxes, {.mirrored_rig = true});
  EXPECT_NEAR(found.deg, 10.0, 1e-6);
  EXPECT_GT(found.deg, found.limit_deg);
}

/// A twist of `deg`, of which joint 2 turns `bend_deg` about left and joint 3 turns it back: in
/// proportion to the twist or, with `power` 2, to its square.
std::vector<glm::dvec3> twisted(double deg, double bend_deg, int power) {
  std::vector<glm::dvec3> turn;
  for (std::size_t f = 0; f < kFrames; ++f) {
    const double t = static_cast<double>(f) / (kFrames - 1);
    for (std::size_t k = 0; k < kJoints; ++k) {
      const double bend = k == 2 ? 1.0 : k == 3 ? -1.0 : 0.0;
      turn.emplace_back(radians_from(bend * bend_deg * std::pow(t, power)),
                        radians_from(deg * t / kJoints), 0.0);
    }
  }
  return turn;
}

TEST(CounterTurns, ABendThatGrowsWithATwistIsFoundWhereBothSidesAreAlike) {
  const ShareExcess found = worst_counter(twisted(30.0, 10.0, 1), kAxes, {.mirrored_rig = true});
  EXPECT_NEAR(found.deg, 10.0, 1e-6);
  EXPECT_GT(found.deg, found.limit_deg);
  // A twist of a bent spine bends it by its square, to either side alike.
  const ShareExcess square = worst_counter(twisted(30.0, 10.0, 2), kAxes, {.mirrored_rig = true});
  EXPECT_LE(square.deg, square.limit_deg);
  const ShareExcess unknown = worst_counter(twisted(30.0, 10.0, 1));
  EXPECT_LE(unknown.deg, unknown.limit_deg);
}

TEST(CounterTurns, SymmetrySaysNothingOfACompoundTurnOrOfMotionInNoProportion) {
  std::vector<glm::dvec3> compound = taken_back(10.0, {0, 1, 0});
  std::vector<glm::dvec3> uneven = compound;
  for (std::size_t f = 0; f < kFrames; ++f)
    for (std::size_t k = 0; k < kJoints; ++k) {
      const double t = static_cast<double>(f) / (kFrames - 1);
      compound[f * kJoints + k].z += radians_from(2.0 * t);
      // One joint leads, another follows.
      if (k == 0 || k == 4) uneven[f * kJoints + k].x *= k == 0 ? 2.0 - t : t;
      if (k == 1) uneven[f * kJoints + k].x += radians_from(4.0 * std::sin(9.0 * t));
    }
  for (const auto& turn : {compound, uneven}) {
    const ShareExcess found = worst_counter(turn, kAxes, {.mirrored_rig = true});
    EXPECT_LE(found.deg, found.limit_deg);
  }
}

TEST(CounterTurns, ABodyThatLiesMayBendToBothSidesInTurn) {
  // Sideways is about up there: the shape of an S, by one control.
  std::vector<glm::dvec3> turn;
  for (std::size_t f = 0; f < kFrames; ++f)
    for (std::size_t k = 0; k < kJoints; ++k)
      turn.emplace_back(
          0.0, radians_from((k < 3 ? 14.0 : -9.0) * static_cast<double>(f) / (kFrames - 1)), 0.0);
  const ShareExcess found = worst_counter(turn, kAxes, {.mirrored_rig = true});
  EXPECT_LE(found.deg, found.limit_deg);
}

TEST(CounterTurns, AMotionThatStaysNearOnePostureTellsNothing) {
  std::vector<glm::dvec3> turn = taken_back(30.0, {0, 1, 0});
  EXPECT_GT(worst_counter(turn).deg, 25.0);
  const std::vector<glm::dvec3> widest(turn.end() - kJoints, turn.end());
  for (std::size_t f = 0; f < kFrames; ++f)
    for (std::size_t k = 0; k < kJoints; ++k)
      turn[f * kJoints + k] = (0.6 + 0.4 * static_cast<double>(f) / (kFrames - 1)) * widest[k];
  EXPECT_EQ(worst_counter(turn).deg, 0.0);
}

TEST(CounterTurns, JointsThatKeepNoProportionRaiseTheLimit) {
  std::vector<glm::dvec3> turn = taken_back(15.0, {0, 1, 0});
  for (std::size_t f = 0; f < kFrames; ++f) {
    const double wander = radians_from(6.0 * std::sin(0.7 * static_cast<double>(f)));
    for (std::size_t k = 0; k < kJoints; ++k) turn[f * kJoints + k].x += wander * (k % 2 ? 1 : -1);
  }
  const ShareExcess last = counter_turns(turn, kJoints, kAxes, {.of_controls = true}).back();
  EXPECT_GT(last.deg, 14.0);
  EXPECT_LT(last.deg, last.limit_deg);
  // Without controls it tells nothing at all.
  EXPECT_EQ(worst_counter(turn).deg, 0.0);
}

TEST(CounterTurns, ABodyThatHardlyTurnsAndTwoJointsTellNothing) {
  std::vector<glm::dvec3> turn = taken_back(15.0, {0, 1, 0});
  for (glm::dvec3& each : turn) each.x = 0.0;  // all joints together turn by nothing
  EXPECT_EQ(worst_counter(turn).deg, 0.0);
  EXPECT_EQ(counter_turns(std::vector<glm::dvec3>(20), 2, kAxes, {}).front().deg, 0.0);
  EXPECT_EQ(counter_turns(std::vector<glm::dvec3>(20), 5, kAxes, {}).front().deg, 0.0);
}

/// A sweep to 40 degrees about an axis that the joints share so; growing evenly with it.
std::vector<glm::dvec3> shared(const std::vector<double>& part, const glm::dvec3& axis) {
  std::vector<glm::dvec3> turn;
  for (std::size_t f = 0; f < kFrames; ++f)
    for (const double each : part)
      turn.push_back(axis * (radians_from(40.0) * each * static_cast<double>(f) / (kFrames - 1)));
  return turn;
}

ShareExcess worst_peak(const std::vector<double>& part, const glm::dvec3& axis,
                       const std::vector<double>& bone = {}) {
  MotionFacts facts{.of_controls = true};
  if (!bone.empty()) facts.rest_place.emplace_back(0.0);
  for (const double each : bone)
    facts.rest_place.push_back(facts.rest_place.back() + glm::dvec3(0.0, each, 0.0));
  return peak_turns(shared(part, axis), part.size(), kAxes, facts).back();
}

TEST(PeakTurns, NoRigIsBlamedForTheWayItSharesABend) {
  for (const glm::dvec3& axis : {glm::dvec3(-1, 0, 0), glm::dvec3(0, 1, 0)})
    for (const std::vector<double>& part : {
             std::vector<double>{0.2, 0.2, 0.2, 0.2, 0.2},  // evenly
             {0.4, 0.3, 0.2, 0.1, 0.0},                     // a slope
             {0.0, 0.0, 0.34, 0.33, 0.33},                  // the upper half
             {0.1, 0.2, 0.35, 0.25, 0.1},                   // a spline
             {0.24, 0.24, 0.2, 0.32, 0.0},                  // by length
             {0.3, 0.45, 0.25},
         }) {
      const ShareExcess found = worst_peak(part, axis);
      EXPECT_LE(found.deg, found.limit_deg) << part[0] << " " << part[1];
    }
  // A vertebra of twice the length turns by twice as much.
  const std::vector<double> by_length = {0.16, 0.16, 0.36, 0.16, 0.16};
  const ShareExcess found = worst_peak(by_length, {1, 0, 0}, {0.16, 0.16, 0.36, 0.16, 0.16});
  EXPECT_LE(found.deg, found.limit_deg);
}

TEST(PeakTurns, AKinkOfTenDegreesAboutTheSweepsOwnAxisIsFoundAtItsJoint) {
  for (const glm::dvec3& axis : {glm::dvec3(-1, 0, 0), glm::dvec3(0, -1, 0)})
    for (const std::size_t joint : {0u, 1u, 2u, 3u}) {
      std::vector<double> part(kJoints, 0.2 - 0.25 / 4);
      part[joint] = 0.45;
      const ShareExcess found = worst_peak(part, axis);
      EXPECT_EQ(found.joint, static_cast<int>(joint));
      EXPECT_NEAR(found.deg, 40.0 * (0.45 - 0.1375), 1e-6);
      EXPECT_GT(found.deg, found.limit_deg);
      EXPECT_EQ(found.beyond, ShareExcess::Beyond::neighbours);
      EXPECT_NEAR(glm::dot(glm::normalize(found.turn), axis), 1.0, 1e-9);
    }
  const ShareExcess of_three = worst_peak({0.15, 0.7, 0.15}, {1, 0, 0});
  EXPECT_GT(of_three.deg, of_three.limit_deg);
}

TEST(PeakTurns, AJointThatTurnsAgainstTheBendBetweenTwoThatGoAlongIsFound) {
  for (const glm::dvec3& axis : {glm::dvec3(1, 0, 0), glm::dvec3(0, -1, 0)})
    for (const std::size_t joint : {1u, 2u, 3u}) {
      std::vector<double> part(kJoints, 0.2 + 0.3 / 4);
      part[joint] = -0.1;  // 12 degrees less than its share
      const ShareExcess found = worst_peak(part, axis);
      EXPECT_EQ(found.joint, static_cast<int>(joint));
      EXPECT_NEAR(found.deg, 40.0 * 0.375, 1e-6);
      EXPECT_GT(found.deg, found.limit_deg);
      EXPECT_NEAR(glm::dot(glm::normalize(found.turn), axis), -1.0, 1e-9);
    }
  // A spline's lowest joint may start against the bend, on the line through those above it.
  const ShareExcess line = worst_peak({-0.1, 0.02, 0.19, 0.42, 0.47}, {1, 0, 0});
  EXPECT_LE(line.deg, line.limit_deg);
}

TEST(PeakTurns, WithoutControlsAnyJointMayBendMost) {
  const std::vector<glm::dvec3> turn = shared({0.1, 0.1, 0.6, 0.1, 0.1}, {1, 0, 0});
  EXPECT_EQ(peak_turns(turn, kJoints, kAxes, {}).back().deg, 0.0);
  const std::vector<ShareExcess> found = joint_excess(turn, kJoints, kAxes, {.of_controls = true});
  EXPECT_EQ(found.back().joint, 2);
  EXPECT_GT(found.back().deg, found.back().limit_deg);
}

TEST(ShareExcess, WordsTellRollFromBendAndWhatItIsBeyond) {
  ShareExcess excess{12.5, 7.0, 2, glm::dvec3(0, radians_from(12.5), 0),
                     ShareExcess::Beyond::neighbours};
  EXPECT_EQ(words_of(excess, {0, 2, 0}), " rolls by 12.5 deg beyond the joints beside it");
  excess.beyond = ShareExcess::Beyond::whole;
  EXPECT_EQ(words_of(excess, {1, 0, 0}), " is bent by 12.5 deg that other joints turn back");
  excess.beyond = ShareExcess::Beyond::share;
  EXPECT_EQ(words_of(excess, {1, 0, 0}),
            " is bent by 12.5 deg beyond its share of the spine's turn");
}

}  // namespace
}  // namespace backbend::validate
