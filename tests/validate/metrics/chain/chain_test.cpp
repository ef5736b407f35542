#include "validate/metrics/chain/chain.h"
#include "tests/validate/metrics/axes.h"
#include "validate/metrics/math/nan.h"

#include <gtest/gtest.h>

#include <random>

namespace backbend::validate {
namespace {

using solver::SpinePose;

// Chords of a curve given as 400 points are off by (1/400)^2 of the turning.
constexpr int kCurvePoints = 401;
constexpr double kChordTolerance = 2e-3;

struct Chain {
  SpinePose pose, rest;
  std::vector<glm::dvec3> intended, intended_rest;
  double expected_twist_deg = kNan;

  ChainMeasures measure() const {
    return measure_chain({pose, rest, intended, intended_rest, expected_twist_deg});
  }
};

/// Length 1, `bones` equal bones bent about X along a circle by `bend` radians in all and twisted
/// by `twist`; joints stand on the circle.
Chain circular(int bones, double bend, double twist = 0.0) {
  Chain c;
  const auto on_circle = [&](double s, double angle) {
    if (angle == 0.0) return kY * s;
    return glm::dvec3(0.0, std::sin(angle * s), 1.0 - std::cos(angle * s)) / angle;
  };
  for (int i = 0; i <= bones; ++i) {
    const double s = static_cast<double>(i) / bones;
    c.rest.position.push_back(on_circle(s, 0.0));
    c.rest.turn.emplace_back(1, 0, 0, 0);
    c.pose.position.push_back(on_circle(s, bend));
    const double middle = std::min(s + 0.5 / bones, 1.0 - 0.5 / bones);
    c.pose.turn.push_back(rotation(kX * (bend * middle)) * rotation(kY * (twist * middle)));
  }
  for (int i = 0; i < kCurvePoints; ++i) {
    const double s = static_cast<double>(i) / (kCurvePoints - 1);
    c.intended_rest.push_back(on_circle(s, 0.0));
    c.intended.push_back(on_circle(s, bend));
  }
  c.rest.chest = {{1, 0, 0, 0}, c.rest.position.back(), c.rest.position.back()};
  c.rest.arms = c.rest.chest;
  c.pose.chest = {rotation(kX * bend) * rotation(kY * twist), c.rest.position.back(),
                  c.pose.position.back()};
  c.pose.arms = c.pose.chest;
  return c;
}

/// Turns everything above a joint about it.
void bend_above(SpinePose& pose, std::size_t joint, const glm::dvec3& turn) {
  const glm::dquat q = rotation(turn);
  const glm::dvec3 pivot = pose.position[joint];
  for (std::size_t i = joint; i < pose.position.size(); ++i) {
    pose.position[i] = pivot + q * (pose.position[i] - pivot);
    pose.turn[i] = q * pose.turn[i];
  }
}

TEST(MeasureChain, AChainOnItsCurveHasNoKinkHoweverSharpTheCurve) {
  for (int bones : {3, 6, 10, 33})
    for (double bend : {0.0, 0.5, 1.5, 3.0}) {
      const ChainMeasures m = circular(bones, bend).measure();
      EXPECT_TRUE(m.finite);
      EXPECT_LT(m.kink_deg, kChordTolerance * (1.0 + bend)) << bones << " bones, bend " << bend;
      EXPECT_NEAR(m.max_turn_deg, degrees(bend) / bones, kChordTolerance);
      EXPECT_NEAR(m.max_over_mean, 1.0, 1e-9);
      EXPECT_TRUE(m.reversed.empty());
    }
}

TEST(MeasureChain, AKinkIsFoundAtItsJointAndSizedToAFewPercentHoweverTheChainIsBent) {
  for (int bones : {8, 10, 24, 33})
    for (double bend : {0.0, 0.7, 2.0})
      for (int joint = 2; joint + 2 < bones; joint += 3)
        for (double kink_deg : {1.0, 4.0}) {
          Chain c = circular(bones, bend);
          // The total bend is kept: half of the kink is taken back on either side.
          const glm::dvec3 kink = kX * radians_from(kink_deg);
          bend_above(c.pose, static_cast<std::size_t>(joint - 1), -0.5 * kink);
          bend_above(c.pose, static_cast<std::size_t>(joint), kink);
          bend_above(c.pose, static_cast<std::size_t>(joint + 1), -0.5 * kink);
          const ChainMeasures m = c.measure();
          EXPECT_EQ(m.kink_joint, joint) << bones << " bones, bend " << bend;
          EXPECT_NEAR(m.kink_deg, kink_deg, 0.06 * kink_deg) << bones << " bones, bend " << bend;
        }
}

TEST(MeasureChain, ACornerThatIsThereAtRestIsNoKinkWhenTheWholeChainTurns) {
  Chain c = circular(8, 0.0);
  bend_above(c.rest, 4, kX * 0.6);  // a curved spine whose curve cuts the corner
  c.pose = c.rest;
  EXPECT_GT(c.measure().max_turn_deg, 30.0);
  EXPECT_LT(c.measure().kink_deg, 1e-9);
  bend_above(c.pose, 0, kZ * 1.2);
  for (glm::dvec3& p : c.intended) p = rotation(kZ * 1.2) * p;
  EXPECT_LT(c.measure().kink_deg, 1e-9);
}

TEST(MeasureChain, ThreeBonesCutTheCornersOfTheSmoothLineTheyStandFor) {
  Chain c = circular(3, 0.0);
  bend_above(c.pose, 2, kX * radians_from(90.0));
  c.intended = circular(3, radians_from(90.0)).intended;
  const ChainMeasures m = c.measure();
  EXPECT_EQ(m.kink_joint, 2);
  EXPECT_GT(m.kink_deg, 30.0);
  EXPECT_NEAR(m.max_over_mean, 2.0, 1e-9);  // all of the bend in one of two joints
}

TEST(MeasureChain, ABoneThatDoublesBackIsNamed) {
  Chain c = circular(10, 1.0);
  EXPECT_TRUE(c.measure().reversed.empty());
  bend_above(c.pose, 9, kX * radians_from(175.0));
  const ChainMeasures m = c.measure();
  ASSERT_EQ(m.reversed.size(), 1u);
  EXPECT_EQ(m.reversed[0], 9);
  EXPECT_EQ(m.kink_joint, 9);
  EXPECT_GT(m.kink_deg, 150.0);
}

TEST(MeasureChain, TwistIsCountedAlongTheBonesAndNotAlongTheBend) {
  for (double bend : {0.0, 1.0, 2.5}) {
    Chain c = circular(10, bend, radians_from(90.0));
    c.expected_twist_deg = 90.0;
    const ChainMeasures m = c.measure();
    EXPECT_NEAR(m.uneven_twist, 1.0, 1e-3) << bend;
    // The last bone stands for its middle: half a bone's twist is not carried by any joint.
    EXPECT_NEAR(m.carried_twist_deg, 90.0 * 9.5 / 10, 0.2) << bend;
    EXPECT_NEAR(m.lost_twist_deg, 90.0 * 0.5 / 10, 0.2);
  }
}

TEST(MeasureChain, TwistInOneJointIsAsUnevenAsThereAreJoints) {
  Chain c = circular(10, 0.0);
  for (std::size_t i = 4; i < c.pose.turn.size(); ++i) c.pose.turn[i] = rotation(kY * 1.0);
  const ChainMeasures m = c.measure();
  EXPECT_NEAR(m.uneven_twist, 9.0, 1e-9);  // nine inner joints
  EXPECT_NEAR(m.twist_deg[4], degrees(1.0), 1e-9);
  EXPECT_TRUE(std::isnan(m.lost_twist_deg));  // nothing was expected, so nothing is said
}

TEST(MeasureChain, TwistInProportionToBonesOfAnyLengthIsEven) {
  Chain c;
  double place = 0.0;
  std::vector<double> at;
  for (const double length : {0.05, 0.3, 0.1, 0.1, 0.35, 0.1}) {
    at.push_back(place);
    place += length;
  }
  at.push_back(place);
  for (std::size_t i = 0; i < at.size(); ++i) {
    c.rest.position.push_back(kY * at[i]);
    c.rest.turn.emplace_back(1, 0, 0, 0);
    const std::size_t bone = std::min(i, at.size() - 2);
    c.pose.turn.push_back(rotation(kY * (1.2 * 0.5 * (at[bone] + at[bone + 1]))));
  }
  c.pose.position = c.rest.position;
  c.intended = c.intended_rest = c.rest.position;
  c.rest.chest = {{1, 0, 0, 0}, c.rest.position.back(), c.rest.position.back()};
  c.rest.arms = c.rest.chest;
  c.pose.chest = {rotation(kY * 1.2), c.rest.position.back(), c.pose.position.back()};
  c.pose.arms = c.pose.chest;
  EXPECT_NEAR(c.measure().uneven_twist, 1.0, 1e-9);
}

TEST(RestExcess, IsWhatTheRestTurnsBeyondItsCurve) {
  Chain c = circular(6, 0.9);
  for (const glm::dvec3& excess : rest_excess(c.pose, c.intended))
    EXPECT_LT(degrees(glm::length(excess)), 0.1);
  bend_above(c.pose, 3, kX * 0.1);
  const std::vector<glm::dvec3> excess = rest_excess(c.pose, c.intended);
  ASSERT_EQ(excess.size(), 7u);
  EXPECT_GT(degrees(excess[3].x), 4.0);
  EXPECT_LT(degrees(glm::length(excess[1])), 1.0);
}

TEST(MeasureChain, OneJointRolledAgainstItsNeighboursIsFoundAndSizedUnderAnySmoothTwist) {
  for (int bones : {5, 6, 7, 10, 24})
    for (double twist : {0.0, 0.8, 1.6})
      for (int joint = 2; joint + 3 <= bones; ++joint) {
        Chain c = circular(bones, 1.2, twist);
        EXPECT_LT(c.measure().twist_jump_deg, 0.05);
        c.pose.turn[joint] = c.pose.turn[joint] * rotation(kY * radians_from(1.0));
        const ChainMeasures m = c.measure();
        const bool whole_window = bones < 7 || (joint >= 3 && joint + 4 <= bones);
        EXPECT_NEAR(m.twist_jump_deg, whole_window ? 1.0 : 0.75, 0.05)
            << bones << " bones, joint " << joint;
        EXPECT_EQ(m.twist_jump_joint, joint) << bones << " bones";
      }
}

TEST(MeasureChain, AStretchedChainIsLongerAndEndsBeyondItsControl) {
  Chain c = circular(10, 0.0);
  for (glm::dvec3& p : c.pose.position) p *= 1.1;
  const ChainMeasures m = c.measure();
  EXPECT_NEAR(m.length, 1.1, 1e-12);
  EXPECT_NEAR(m.length_change, 0.1, 1e-12);
  EXPECT_NEAR(m.end_gap, 0.1, 1e-12);
  EXPECT_NEAR(measure_chain({c.pose, c.rest, c.intended, c.intended_rest, kNan, 1.1}).length_change,
              0.0, 1e-12);
}

TEST(MeasureChain, TheLeastMarginIsThatOfTheJointNearestToItsSingularPose) {
  Chain c = circular(3, 0.0);
  EXPECT_TRUE(std::isnan(c.measure().least_margin_deg));
  c.pose.flip_margin = {1.0, 0.1, 0.5, 0.7};
  EXPECT_NEAR(c.measure().least_margin_deg, degrees(0.1), 1e-12);
  EXPECT_EQ(c.measure().least_margin_joint, 1);
}

TEST(MeasureChain, TheSameChainInAnotherWorldMeasuresTheSame) {
  Chain c = circular(9, 1.3, 0.8);
  bend_above(c.pose, 4, kX * 0.3 + kZ * 0.2);
  const ChainMeasures here = c.measure();
  const glm::dquat turn = glm::normalize(glm::dquat(0.3, 0.8, -0.4, 0.2));
  const glm::dvec3 shift(3, -7, 11);
  const double scale = 0.01;
  const auto move = [&](glm::dvec3& p) { p = turn * (p * scale) + shift; };
  for (SpinePose* pose : {&c.pose, &c.rest}) {
    for (glm::dvec3& p : pose->position) move(p);
    for (glm::dquat& q : pose->turn) q = turn * q * glm::conjugate(turn);
    for (solver::RigidMotion* m : {&pose->hip, &pose->chest, &pose->arms}) {
      m->turn = turn * m->turn * glm::conjugate(turn);
      move(m->rest_origin);
      move(m->posed_origin);
    }
  }
  for (auto* curve : {&c.intended, &c.intended_rest})
    for (glm::dvec3& p : *curve) move(p);
  const ChainMeasures there = c.measure();
  // A shift by 11 of a chain of length 0.01 costs three digits.
  EXPECT_NEAR(there.kink_deg, here.kink_deg, 1e-9);
  EXPECT_EQ(there.kink_joint, here.kink_joint);
  EXPECT_NEAR(there.max_over_mean, here.max_over_mean, 1e-9);
  EXPECT_NEAR(there.carried_twist_deg, here.carried_twist_deg, 1e-9);
  EXPECT_NEAR(there.arms.rotation_deg, here.arms.rotation_deg, 1e-6);
  EXPECT_NEAR(there.end_gap, here.end_gap, 1e-9);
}

TEST(MeasureChain, WhatIsNotANumberIsSaidAndNotMeasured) {
  Chain c = circular(5, 0.4);
  c.pose.position[3].y = kNan;
  EXPECT_FALSE(c.measure().finite);
  c = circular(5, 0.4);
  c.pose.turn[2].x = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(c.measure().finite);
  c = circular(5, 0.4);
  c.pose.flip_margin = {kNan};
  EXPECT_FALSE(c.measure().finite);
}

/// Arms that carry the shortest arc of what an Euler control turns.
SpinePose arms_on_a_minimal_swing(double y, double z) {
  SpinePose pose;
  pose.chest.turn = rotation(kZ * z) * rotation(kY * y);
  pose.arms.turn = rotation(arc_between(kX, pose.chest.turn * kX));
  return pose;
}

TEST(ArmDrift, IsTheHiddenEulerTwistOfTheThesisRig) {
  const struct {
    double y, z, drift;
  } cases[] = {{30, 30, 8.21}, {45, 45, 19.47}, {60, 60, 36.87}, {30, 90, 30.00}, {0, 90, 0}};
  for (const auto& c : cases) {
    const double y = radians_from(c.y), z = radians_from(c.z);
    const ArmDrift drift = arm_drift(arms_on_a_minimal_swing(y, z), kX, 1.0);
    EXPECT_NEAR(std::abs(drift.twist_deg), c.drift, 0.005) << c.y << ' ' << c.z;
    EXPECT_NEAR(drift.aim_deg, 0.0, 1e-6);
    const EulerChannels control{0.0, y, z};
    const ArmDriftStory story = explain_arm_drift(drift, {&control, 1}, true);
    EXPECT_NEAR(story.hidden_euler_deg, drift.twist_deg, 1e-9);
    EXPECT_NEAR(story.holonomy_deg, 0.0, 1e-9);
  }
}

TEST(ArmDrift, WhatBendsAboutTwoAxesEncloseIsHolonomyAndStaysUnderItsBound) {
  // Middle bends about Z, Top about Y: two minimal swings in turn, against one shortest arc.
  const double a = radians_from(60.0);
  SpinePose pose;
  pose.chest.turn = rotation(kZ * a) * rotation(kY * a);
  pose.arms.turn = rotation(arc_between(kX, pose.chest.turn * kX));
  const std::array<EulerChannels, 2> controls{{{0, 0, a}, {0, a, 0}}};
  const ArmDrift drift = arm_drift(pose, kX, 1.0);
  const ArmDriftStory story = explain_arm_drift(drift, controls, true);
  EXPECT_EQ(story.hidden_euler_deg, 0.0);
  EXPECT_NEAR(story.holonomy_deg, drift.twist_deg, 1e-9);
  // tan(E/2) = tan(a/2) tan(b/2) for the cut corner
  EXPECT_NEAR(std::abs(story.holonomy_deg), 36.87, 0.005);
}

TEST(ArmDrift, ALostTwistIsToldFromTheOtherCauses) {
  SpinePose pose;
  pose.chest.turn = rotation(kX * radians_from(40.0));
  const std::array<EulerChannels, 2> controls{{{radians_from(40.0), 0, 0}, {0, 0, 0}}};
  const ArmDrift drift = arm_drift(pose, kX, 1.0);
  EXPECT_NEAR(drift.twist_deg, -40.0, 1e-9);
  EXPECT_NEAR(explain_arm_drift(drift, controls, true).lost_twist_deg, -40.0, 1e-9);
  EXPECT_NEAR(explain_arm_drift(drift, controls, true).holonomy_deg, 0.0, 1e-9);
  EXPECT_NEAR(explain_arm_drift(drift, controls, false).holonomy_deg, -40.0, 1e-9);
  // What the last control rolls is what the arms do follow; all before it is lost.
  const double a = radians_from(40.0), b = radians_from(7.0), c = radians_from(-15.0);
  const std::array<EulerChannels, 3> rolls{{{a, 0, 0}, {b, 0, 0}, {c, 0, 0}}};
  EXPECT_NEAR(explain_arm_drift(drift, rolls, true).lost_twist_deg, -47.0, 1e-9);
  EXPECT_EQ(explain_arm_drift(drift, rolls, false).lost_twist_deg, 0.0);
}

TEST(ArmDrift, AimTwistAndShiftAreSeparate) {
  SpinePose pose;
  pose.chest = {rotation(kZ * 0.7), glm::dvec3(0), glm::dvec3(1, 2, 3)};
  pose.arms = pose.chest;
  ArmDrift drift = arm_drift(pose, kX, 2.0);
  EXPECT_NEAR(drift.rotation_deg, 0.0, 1e-9);
  EXPECT_EQ(drift.shift, 0.0);
  pose.arms.turn = pose.chest.turn * rotation(kX * radians_from(3.0));
  pose.arms.posed_origin += kZ * 0.1;
  drift = arm_drift(pose, kX, 2.0);
  EXPECT_NEAR(drift.twist_deg, 3.0, 1e-9);
  EXPECT_NEAR(drift.aim_deg, 0.0, 1e-9);
  EXPECT_NEAR(drift.shift, 0.05, 1e-12);
  pose.arms.turn = pose.chest.turn * rotation(kY * radians_from(3.0));
  drift = arm_drift(pose, kX, 2.0);
  EXPECT_NEAR(drift.twist_deg, 0.0, 1e-9);
  EXPECT_NEAR(drift.aim_deg, 3.0, 1e-9);
}

TEST(HiddenEulerTwist, IsFiniteWhereTheTangentsAreNot) {
  EXPECT_NEAR(degrees(hidden_euler_twist(kPi, 0.5 * kPi)), 180.0, 1e-9);
  EXPECT_EQ(hidden_euler_twist(kPi, 0.0), 0.0);
  EXPECT_TRUE(std::isfinite(hidden_euler_twist(kPi, kPi)));
}

TEST(Mirrored, TwiceIsTheSamePoseAndTurnsMirrorAsPicturesDo) {
  const SpinePose pose = circular(6, 1.0, 0.5).pose;
  const glm::dvec3 left = glm::normalize(glm::dvec3(1, 0.2, 0.1)), origin(0.3, 0.1, 0.2);
  const PoseDifference twice =
      pose_difference(pose, mirrored(mirrored(pose, left, origin), left, origin), 1.0);
  EXPECT_LT(twice.shift, 1e-14);
  EXPECT_LT(twice.turn_deg, 1e-12);
  // A bend in the mirror's plane mirrors to itself, a twist to its opposite.
  SpinePose turned;
  turned.turn = {rotation(kX * 0.4), rotation(kY * 0.4), rotation(kZ * 0.4)};
  turned.position = {kX, kY, kZ};
  const SpinePose seen = mirrored(turned, kX, glm::dvec3(0));
  EXPECT_LT(angle_between(seen.turn[0], rotation(kX * 0.4)), 1e-15);
  EXPECT_LT(angle_between(seen.turn[1], rotation(kY * -0.4)), 1e-15);
  EXPECT_LT(angle_between(seen.turn[2], rotation(kZ * -0.4)), 1e-15);
  EXPECT_EQ(seen.position[0], -kX);
  EXPECT_EQ(seen.position[1], kY);
  // Hips, chest and arms each go along, with their origins.
  turned.hip = {rotation(kY * 0.1), kX, kX + kY};
  turned.chest = {rotation(kY * 0.2), kX * 2.0, kX * 2.0 + kY};
  turned.arms = {rotation(kY * 0.3), kX * 3.0, kX * 3.0 + kY};
  const SpinePose whole = mirrored(turned, kX, glm::dvec3(0));
  const solver::RigidMotion* const motions[] = {&whole.hip, &whole.chest, &whole.arms};
  for (int i = 0; i < 3; ++i) {
    EXPECT_LT(angle_between(motions[i]->turn, rotation(kY * (-0.1 * (i + 1)))), 1e-15);
    EXPECT_EQ(motions[i]->rest_origin, kX * (-1.0 - i));
    EXPECT_EQ(motions[i]->posed_origin, kX * (-1.0 - i) + kY);
  }
}

TEST(PoseDifference, NeverHidesWhatIsNotANumber) {
  const SpinePose a = circular(4, 0.5).pose;
  SpinePose b = a;
  b.position[1].x = kNan;
  EXPECT_TRUE(std::isnan(pose_difference(a, b, 1.0).shift));
  EXPECT_EQ(pose_difference(a, a, 1.0).shift, 0.0);
}

TEST(Response, IsTheGainAndTheTiltOfTheAxis) {
  const glm::dquat a = rotation(kZ * 0.4), b = rotation(kZ * 0.5);
  EXPECT_NEAR(response(a, b, a, b).gain, 1.0, 1e-12);
  EXPECT_NEAR(response(a, b, a, b).axis_deg, 0.0, 1e-6);
  EXPECT_NEAR(response(a, b, rotation(kX * 0.1), rotation(kX * 0.3)).gain, 2.0, 1e-12);
  EXPECT_NEAR(response(a, b, rotation(kX * 0.1), rotation(kX * 0.3)).axis_deg, 90.0, 1e-9);
  EXPECT_TRUE(std::isnan(response(a, a, a, b).gain));
}

}  // namespace
}  // namespace backbend::validate
