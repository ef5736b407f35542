// The thesis's curve spine. R-numbers are those of research/seeds.md; "(oracle)" numbers come from
// an independent double-precision model of `interpolate` + `on_curve`; the tables without a number
// are research/spine.md 2.4, 2.5 and 13, for the defaults.
#include <algorithm>
#include <cmath>
#include <numeric>

#include "solver/curves/curve.h"
#include "solver/curves/curve_chain.h"
#include "tests/solver/rig_fixture.h"

namespace backbend::solver {
namespace {

using namespace rigs;

Options oracle(Options more = {}) {
  more.insert({{"basis", "interpolate"}, {"follow", "on_curve"}});
  return more;
}

constexpr double kOracle = 1e-4 * 6.0;  // research/seeds.md, section 1: 1e-4 of the fixture's size

// ---- what the curve is ----

TEST(CurveSpine, FivePointsRideOnTheirBones) {  // R21, R24, R25
  const auto curve = build("curve", {{"basis", "linear"}});
  EXPECT_NEAR(measure(curve->solve(pose_b()), "curve_length"), 2 + 4 * std::cos(radians(15)), 1e-9);
  // Bends f1, f2 between bones of length 2: 2 + 2 cos(f1/2) + 2 cos(f2/2).
  const auto bent = pose_deg({10, 20, 30}, {0, 0, 40}, {0, -70, 0});
  EXPECT_NEAR(measure(curve->solve(bent), "curve_length"),
              2 + 2 * std::cos(radians(20)) + 2 * std::cos(radians(35)), 1e-9);
}

TEST(CurveSpine, LengthFollowsTheBendAsTabulated) {  // spine.md 13.5
  const double table[][3] = {
      {30, .955, .977}, {45, .902, .949}, {60, .833, .911}, {90, .667, .805}, {120, .500, .667}};
  for (const auto& [deg, bspline, linear] : table) {
    const auto pose = pose_deg({0, 0, 0}, {0, 0, deg}, {0, 0, deg});
    EXPECT_NEAR(measure(build("curve")->solve(pose), "curve_length") / 6.0, bspline, 5.1e-4) << deg;
    const double closed = (1 + 2 * std::cos(radians(deg / 2))) / 3;
    const auto polyline = build("curve", {{"basis", "linear"}});
    EXPECT_NEAR(measure(polyline->solve(pose), "curve_length") / 6.0, closed, 1e-12) << deg;
    EXPECT_NEAR(closed, linear, 5.1e-4);
  }
}

TEST(CurveSpine, InterpolatingCurveHasTheOraclesLengths) {  // R26
  struct {
    RestChain chain;
    const char* knots;
    std::vector<double> pose;
    double length;
  } const rows[] = {
      {straight(), "chord", pose_a(), 6.0},          {straight(), "chord", pose_b(), 5.899776},
      {straight(), "chord", pose_c(), 5.590445},     {straight(), "chord", pose_e(), 5.818624},
      {straight(), "chord", pose_f(), 4.893260},     {curved(), "chord", pose_a(), 6.202929},
      {curved(), "chord", pose_b(), 6.226970},       {curved(), "chord", pose_c(), 5.502090},
      {curved(), "chord", pose_f(), 4.932138},       {straight(), "uniform", pose_f(), 4.7592},
      {straight(), "centripetal", pose_f(), 4.8077},
  };
  for (const auto& row : rows) {
    const auto curve = build("curve", oracle({{"knots", row.knots}}), row.chain);
    EXPECT_NEAR(measure(curve->solve(row.pose), "curve_length"), row.length, 5.1e-5) << row.knots;
  }
}

TEST(CurveSpine, PlanarPosesStayExactlyInThePlane) {  // R20
  for (const RestChain& chain : {straight(), curved()}) {
    for (const Options& o : {Options{}, oracle(), Options{{"basis", "linear"}}}) {
      const auto curve = build("curve", o, chain);
      for (const auto& pose : {pose_a(), pose_b(), pose_c(), pose_f()}) {
        for (const dvec3& p : curve->solve(pose).position) EXPECT_EQ(p.x, 0.0);
      }
    }
  }
}

TEST(CurveSpine, CurveStaysClearOfTheHingesThatItRounds) {  // R22
  const auto nearest = [](const std::vector<double>& pose, std::size_t joint) {
    const auto fk = build("three_bone");
    const dvec3 hinge = fk->solve(pose).position[joint];
    const auto points = build("curve", oracle())->intended_curve(pose, 20001);
    double least = 1e9;
    for (const dvec3& p : points) least = std::min(least, glm::length(p - hinge));
    return least;
  };
  for (std::size_t joint : {1, 2}) {
    EXPECT_NEAR(nearest(pose_b(), joint), 0.145965, 1e-6);
    EXPECT_NEAR(nearest(pose_c(), joint), 0.300744, 1e-6);
  }
}

// ---- how the chain follows it ----

TEST(CurveSpine, BendIsSpreadOverTheChainAndPilesUpInTheDeepFold) {  // R4, R156
  const auto curve = build("curve", oracle());
  const auto b = joint_angles_deg(curve->solve(pose_b()));
  const double expected[] = {3.26, 5.86, 7.44, 9.24, 10.51, 9.23, 7.43, 5.85, 3.24};
  ASSERT_EQ(b.size(), std::size(expected));
  for (std::size_t i = 0; i < b.size(); ++i) EXPECT_NEAR(b[i], expected[i], 0.006) << i;
  const SpinePose f = curve->solve(pose_f());
  EXPECT_NEAR(measure(curve->solve(pose_b()), "max_over_mean_turn"), 1.525, 1e-3);
  EXPECT_NEAR(measure(curve->solve(pose_c()), "max_over_mean_turn"), 1.619, 1e-3);
  EXPECT_NEAR(measure(f, "max_over_mean_turn"), 6.385, 5e-3);
  EXPECT_NEAR(measure(f, "max_turn_deg"), 109.7, 0.1);
}

TEST(CurveSpine, WalkedJointsLieOnTheCurveUntilItEnds) {  // R30
  const auto curve = build("curve", oracle(), curved());
  for (const auto& pose : {pose_b(), pose_c(), pose_e(), pose_f()}) {
    const SpinePose solved = curve->solve(pose);
    const auto line = curve->intended_curve(pose, 100001);
    const std::size_t past = measure(solved, "overrun") > 0.0 ? 1 : 0;  // under a bone: one joint
    for (std::size_t i = 0; i + past < solved.joint_count(); ++i) {
      double least = 1e9;
      for (const dvec3& p : line) least = std::min(least, glm::length(p - solved.position[i]));
      EXPECT_LT(least, 4e-5) << i;  // half a step of the sampled curve
    }
  }
}

TEST(CurveSpine, EveryBoneHasTheSameLengthAndItIsTheReportedOne) {  // R33
  for (const char* follow : {"chase", "on_curve"}) {
    for (const char* length : {"nulls", "rest", "null_sum", "arc", "close"}) {
      const auto curve = build("curve", {{"follow", follow}, {"length", length}}, curved());
      for (const auto& pose : {pose_b(), pose_e(), pose_f()}) {
        const SpinePose solved = curve->solve(pose);
        const double bone = measure(solved, "bone_length");
        for (std::size_t i = 1; i < solved.joint_count(); ++i) {
          EXPECT_NEAR(glm::length(solved.position[i] - solved.position[i - 1]), bone, 1e-12)
              << follow << length;
        }
      }
    }
  }
}

TEST(CurveSpine, FrozenBonesOverrunAndLiveOnesReachTheEnd) {  // R31
  const auto frozen = build("curve", oracle({{"length", "rest"}}));
  const auto live = build("curve", oracle());
  const auto gap = [](const SpinePose& pose) { return measure(pose, "tip_gap"); };
  EXPECT_NEAR(gap(frozen->solve(pose_b())), 0.103996, 1e-6);
  EXPECT_NEAR(gap(frozen->solve(pose_c())), 0.426089, 1e-6);
  EXPECT_NEAR(gap(frozen->solve(pose_f())), 1.581558, 1e-6);
  EXPECT_NEAR(gap(live->solve(pose_b())), 0.003329, 1e-6);
  EXPECT_NEAR(gap(live->solve(pose_c())), 0.013179, 1e-6);
  EXPECT_NEAR(gap(live->solve(pose_f())), 0.045309, 1e-6);
}

TEST(CurveSpine, PastTheEndTheChainRunsStraightOnAndSaysSo) {  // R32
  const auto frozen = build("curve", oracle({{"length", "rest"}}));
  const SpinePose f = frozen->solve(pose_f());
  EXPECT_GT(measure(f, "overrun"), 1.0);
  EXPECT_FALSE(f.flags.empty());
  const auto angles = joint_angles_deg(f);
  EXPECT_LT(angles.back(), 1e-9);  // two bones on the continuation
  EXPECT_TRUE(build("curve", oracle())->solve(pose_b()).flags.empty());
}

TEST(CurveSpine, UncompensatedChainKinksBetween45And60AndTheNullsCureIt) {  // spine.md 2.4, 13.6
  const auto frozen = build("curve", {{"length", "rest"}});
  const auto nulls = build("curve");
  const double table[][3] = {
      {30, 6.6, 6.3}, {45, 11.2, 10.0}, {60, 177, 14.6}, {90, 137, 30.2}, {120, 169, 73}};
  for (const auto& [deg, kinked, cured] : table) {
    const auto pose = pose_deg({0, 0, 0}, {0, 0, deg}, {0, 0, deg});
    EXPECT_NEAR(measure(frozen->solve(pose), "max_turn_deg"), kinked, deg < 50 ? 0.06 : 1.0) << deg;
    EXPECT_NEAR(measure(nulls->solve(pose), "max_turn_deg"), cured, deg < 100 ? 0.06 : 0.6) << deg;
  }
  EXPECT_GT(measure(frozen->solve(pose_deg({0, 0, 0}, {0, 0, -60}, {0, 0, -60})), "max_turn_deg"),
            150);
}

TEST(CurveSpine, FrozenBonesOnTheCurveOverrunInsteadOfKinking) {  // spec 4.2, length = "rest"
  const auto walked = build("curve", {{"length", "rest"}, {"follow", "on_curve"}});
  const SpinePose pose = walked->solve(pose_deg({0, 0, 0}, {0, 0, 60}, {0, 0, 60}));
  EXPECT_LT(measure(pose, "max_turn_deg"), 20);
  EXPECT_GT(measure(pose, "overrun"), 0.9);
}

TEST(CurveSpine, PolylineKinksAsMuchAsThreeBonesDo) {  // spine.md 2.3, contradiction 2
  const auto linear = build("curve", {{"basis", "linear"}});
  EXPECT_NEAR(measure(linear->solve(pose_deg({0, 0, 0}, {0, 0, 60}, {0, 0, 60})), "max_turn_deg"),
              60.9, 0.06);
}

// ---- bone length ----

TEST(CurveSpine, BoneIsNineTimesTheFirstNullGapOverTheCount) {  // R34, A6
  const auto bone = [](double bones) {
    return measure(build("curve", {{"bones", bones}})->solve(pose_d()), "bone_length");
  };
  EXPECT_NEAR(bone(10), 0.6, 1e-12);
  EXPECT_NEAR(bone(8), 0.75, 1e-12);  // not 7/8 of it, and not 10/8
}

TEST(CurveSpine, NullGapsAreEqualByArcButNotByChord) {  // R36
  const SpinePose f = build("curve", oracle())->solve(pose_f());
  EXPECT_NEAR(measure(f, "length_by_first_null"), 4.893246, 1e-6);
  EXPECT_NEAR(measure(f, "length_by_null_sum"), 4.744875, 1e-6);
  EXPECT_NEAR(measure(f, "curve_length"), 4.893260, 1e-6);
}

TEST(CurveSpine, FirstNullEstimateIsGoodTo015PercentAndExactOnAPolyline) {  // spine.md 13.9
  for (const double deg : {30., 60., 90., 120.}) {
    const auto pose = pose_deg({0, 0, 0}, {0, 0, deg}, {0, 0, deg});
    const SpinePose smooth = build("curve")->solve(pose);
    EXPECT_NEAR(measure(smooth, "length_by_first_null") / measure(smooth, "curve_length"), 1.0,
                1.5e-3);
    const SpinePose linear = build("curve", {{"basis", "linear"}})->solve(pose);
    EXPECT_NEAR(measure(linear, "length_by_first_null"), measure(linear, "curve_length"), 1e-12);
  }
}

TEST(CurveSpine, CloseMeetsTheTipInEveryPoseBothWaysOfFollowing) {  // R155
  for (const char* follow : {"chase", "on_curve"}) {
    for (const char* basis : {"bspline", "interpolate", "linear"}) {
      for (const double bones : {1., 7., 10., 64.}) {
        const auto curve = build(
            "curve", {{"follow", follow}, {"basis", basis}, {"length", "close"}, {"bones", bones}},
            curved());
        for (const auto& pose : {pose_b(), pose_c(), pose_e()}) {
          const SpinePose solved = curve->solve(pose);
          EXPECT_LT(measure(solved, "tip_gap"), 1e-9) << follow << " " << basis << " " << bones;
          EXPECT_TRUE(solved.flags.empty());
        }
      }
    }
  }
}

TEST(CurveSpine, CloseSaysSoWhereNoBoneLengthCanMeetTheTip) {
  // Two bones walked along a polyline folded in three: at no length does the first joint that the
  // walk meets stand as far from the root as from the tip.
  const auto curve = build(
      "curve", {{"follow", "on_curve"}, {"basis", "linear"}, {"length", "close"}, {"bones", 2.0}},
      curved());
  const SpinePose pose = curve->solve(pose_c());
  EXPECT_GT(measure(pose, "tip_gap"), 0.1);
  EXPECT_FALSE(pose.flags.empty());
}

TEST(CurveSpine, TipGapAfterTheCureIsUnderOnePercentOfABone) {  // spine.md 2.4
  for (double deg = 0; deg <= 120; deg += 10) {
    const SpinePose pose = build("curve")->solve(pose_deg({0, 0, 0}, {0, 0, deg}, {0, 0, deg}));
    EXPECT_LE(measure(pose, "tip_gap"), 0.009 * 2.0) << deg;
  }
}

TEST(CurveSpine, RestOfACurvedChainIsTheChainBuiltOnItsCurve) {  // R161
  const auto curve = build("curve", oracle(), curved());
  EXPECT_NEAR(measure(curve->rest(), "bone_length"), 0.620267, 1e-6);
  EXPECT_NEAR(measure(curve->rest(), "tip_gap"), 0.001198, 1e-6);
  EXPECT_EQ(curve->rest().position, curve->solve(pose_a()).position);
}

// ---- twist ----

TEST(CurveSpine, TopRollIsSharedEvenlyAndMovesNoJoint) {  // R49, R50, R54
  const auto curve = build("curve");
  for (const double deg : {60., 400., -720.}) {
    const SpinePose pose = curve->solve(pose_deg({0, 0, 0}, {0, 0, 0}, {deg, 0, 0}));
    for (std::size_t i = 0; i < 10; ++i) {
      const dquat expected = turn_about({0, 1, 0}, radians(deg) * double(i + 1) / 10);
      EXPECT_LT(degrees(angle_between(pose.turn[i], expected)), 1e-9) << deg << " bone " << i;
    }
    for (std::size_t i = 0; i < 11; ++i)
      expect_near(pose.position[i], curve->rest().position[i], 1e-12);
  }
}

TEST(CurveSpine, RollComesFromTheXChannelAlone) {  // R51
  const auto curve = build("curve");
  EXPECT_EQ(measure(curve->solve(pose_deg({0, 0, 0}, {0, 0, 0}, {0, 60, 0})), "roll_deg"), 0.0);
  EXPECT_NEAR(measure(curve->solve(pose_deg({0, 0, 0}, {0, 0, 0}, {60, 0, 0})), "roll_deg"), 60.0,
              1e-12);
}

TEST(CurveSpine, LowerTwistIsCarriedAndMiddleTwistIsLost) {  // R52
  for (const RestChain& chain : {straight(), curved()}) {
    const double expected = chain.joint[1].z == 0 ? 60.0 : 60.136;  // oracle
    const auto literal = build("curve", oracle(), chain);
    EXPECT_NEAR(measure(literal->solve(pose_g()), "arm_drift_twist_deg"), 0.0, 1e-9);
    EXPECT_NEAR(measure(literal->solve(pose_h()), "arm_drift_twist_deg"), expected, 6e-4);
    const auto full = build("curve", oracle({{"roll", "full"}}), chain);
    EXPECT_NEAR(measure(full->solve(pose_h()), "arm_drift_twist_deg"), 0.0, 1e-9);
  }
}

TEST(CurveSpine, FullRollIsUnwrappedPastAnyTurn) {
  const auto curve = build("curve", {{"roll", "full"}});
  for (double deg = -720; deg <= 720; deg += 90) {
    const SpinePose pose = curve->solve(pose_deg({0, 0, 0}, {deg / 2, 0, 0}, {deg / 2, 0, 0}));
    if (deg != 0) {
      EXPECT_NEAR(measure(pose, "roll_deg"), deg, 1e-9);
    }
  }
  const auto twist = [](double deg) { return pose_deg({0, 0, 0}, {deg, 0, 10}, {deg, 15, 20}); };
  EXPECT_LT(largest_step_deg(*curve, twist, 0, 400, 1), 2.5);
}

// ---- arm drift: what hangs from the last bone against the top control ----

TEST(CurveSpine,
     ArmDriftIsTheTwistHiddenInTheEulerOrder) {  // spine.md 2.5, 13.7: 2 atan(tan y/2 tan z/2)
  const auto curve = build("curve");
  const double table[][3] = {{30, 30, 8.21}, {45, 45, 19.47}, {60, 60, 36.87}, {30, 90, 30.00}};
  for (const auto& [y, z, listed] : table) {
    const double closed =
        degrees(2 * std::atan(std::tan(radians(y / 2)) * std::tan(radians(z / 2))));
    EXPECT_NEAR(closed, listed, 0.005);
    const SpinePose pose = curve->solve(pose_deg({0, 0, 0}, {0, 0, 0}, {0, y, z}));
    EXPECT_NEAR(measure(pose, "arm_drift_twist_deg"), closed, 1e-6) << y << " " << z;
  }
  EXPECT_NEAR(
      measure(curve->solve(pose_deg({0, 0, 0}, {0, 0, 0}, {0, 0, 80})), "arm_drift_twist_deg"), 0,
      1e-9);
  EXPECT_NEAR(
      measure(curve->solve(pose_deg({0, 0, 0}, {0, 0, 0}, {0, 80, 0})), "arm_drift_twist_deg"), 0,
      1e-9);
}

TEST(CurveSpine, ArmDriftOfMixedBendsIsTheTabulatedHolonomy) {  // spine.md 2.5
  const auto curve = build("curve");
  const auto drift = [&](dvec3 middle, dvec3 top) {
    return measure(curve->solve(pose_deg({0, 0, 0}, middle, top)), "arm_drift_twist_deg");
  };
  EXPECT_NEAR(drift({0, 0, 60}, {0, 60, 0}), 11.43, 0.02);
  EXPECT_NEAR(drift({0, 0, 60}, {0, 60, 60}), 50.6, 0.06);
  EXPECT_NEAR(drift({0, 30, 30}, {0, 30, 30}), 17.2, 0.06);
  EXPECT_NEAR(drift({0, 0, 90}, {0, 0, 90}), 0.0, 1e-9);
  EXPECT_NEAR(drift({40, 0, 0}, {0, 0, 0}), 40.0, 1e-9);
  EXPECT_NEAR(drift({0, 0, 0}, {40, 0, 0}), 0.0, 1e-9);
}

TEST(CurveSpine, FullRollOrArmsOnTheTopControlEndTheDrift) {  // W1, W2
  const auto full = build("curve", oracle({{"roll", "full"}}), curved());
  EXPECT_NEAR(measure(full->solve(pose_e()), "arm_drift_twist_deg"), 0.0, 1e-6);
  const auto literal = build("curve", oracle());
  EXPECT_NEAR(measure(literal->solve(pose_e()), "arm_drift_twist_deg"), 12.110, 1e-3);  // oracle
  const auto top = build("curve", {{"arms", "top"}});
  const SpinePose pose = top->solve(pose_e());
  EXPECT_EQ(angle_between(pose.arms.turn, pose.chest.turn), 0.0);
  expect_near(pose.arms.posed_origin, pose.chest.posed_origin, 0.0);
}

TEST(CurveSpine, AimGapIsTheOraclesPredictability) {  // R15
  const auto curve = build("curve", oracle());
  const auto gap = [&](const std::vector<double>& pose) {
    return measure(curve->solve(pose), "aim_gap_deg");
  };
  EXPECT_NEAR(gap(pose_b()), 1.027, 1e-3);
  EXPECT_NEAR(gap(pose_c()), 2.340, 1e-3);
  EXPECT_NEAR(gap(pose_f()), 1.473, 1e-3);
}

TEST(CurveSpine, ArmsHangFromTheTip) {
  const auto curve = build("curve");
  const SpinePose pose = curve->solve(pose_e());
  EXPECT_EQ(angle_between(pose.arms.turn, pose.turn.back()), 0.0);
  EXPECT_EQ(pose.arms.posed_origin, pose.position.back());
  EXPECT_EQ(pose.arms.rest_origin, curve->rest().position.back());
  expect_near(pose.chest.posed_origin, build("three_bone")->solve(pose_e()).position.back(), 1e-12);
}

// ---- no flips below a half turn ----

TEST(CurveSpine, SweepsOfTheThesisStayFiniteAndSmooth) {  // R17, R66 (oracle)
  const auto top = [](double deg) { return pose_deg({0, 0, 0}, {0, 0, 0}, {0, 0, deg}); };
  const auto all = [](double deg) { return pose_deg({0, 0, deg}, {0, 0, deg}, {0, 0, deg}); };
  const auto twist = [](double deg) { return pose_deg({0, 0, 0}, {0, 0, 0}, {deg, 0, 0}); };
  const auto curve = build("curve", oracle());
  EXPECT_LE(largest_step_deg(*curve, top, 0, -175, -1), 2.5);
  EXPECT_NEAR(largest_step_deg(*curve, top, 0, -175, -1), 2.11, 0.02);
  EXPECT_NEAR(largest_step_deg(*curve, all, 0, -90, -1), 3.07, 0.01);
  EXPECT_NEAR(largest_step_deg(*build("curve", oracle(), curved()), all, 0, -90, -1), 3.17, 0.01);
  EXPECT_NEAR(largest_step_deg(*curve, twist, 0, 720, 2), 2.0, 1e-9);
}

TEST(CurveSpine, PlanarFoldPastHalfATurnKeepsItsSideAxis) {  // R157 (oracle)
  const auto top = [](double deg) { return pose_deg({0, 0, 0}, {0, 0, 0}, {0, 0, deg}); };
  const struct {
    RestChain chain;
    double step;
  } rows[] = {{straight(), 2.215}, {curved(), 2.281}};
  for (const auto& row : rows) {
    const auto curve = build("curve", oracle(), row.chain);
    EXPECT_NEAR(largest_step_deg(*curve, top, 0, -270, -1), row.step, 0.01);
    for (double deg = 0; deg >= -270; deg -= 1) {
      for (const dquat& q : curve->solve(top(deg)).turn)
        expect_near(q * dvec3(1, 0, 0), {1, 0, 0}, 1e-9);
    }
  }
}

TEST(CurveSpine, MarginIsWhatTheSharpestTurnLeavesBeforeDoublingBack) {
  const auto kinked = build("curve", {{"length", "rest"}});
  const SpinePose pose = kinked->solve(pose_deg({0, 0, 0}, {0, 0, 60}, {0, 0, 60}));
  EXPECT_NEAR(degrees(*std::min_element(pose.flip_margin.begin(), pose.flip_margin.end())),
              180.0 - measure(pose, "max_turn_deg"), 1e-6);
}

// ---- how many bones, and odd chains ----

TEST(CurveSpine, TakesOneToSixtyFourBones) {  // R27, R29
  for (const double bones : {1., 3., 8., 9., 10., 40., 64.}) {
    const auto curve = build("curve", {{"bones", bones}});
    const SpinePose pose = curve->solve(pose_e());
    EXPECT_EQ(pose.joint_count(), std::size_t(bones) + 1);
    EXPECT_EQ(curve->joint_names().size(), pose.joint_count());
    EXPECT_EQ(curve->arc_fraction().size(), pose.joint_count());
    EXPECT_EQ(curve->joint_names().back(), "tip");
  }
  EXPECT_THROW(build("curve", {{"bones", 0.0}}), RigError);
  EXPECT_THROW(build("curve", {{"bones", 65.0}}), RigError);
  EXPECT_THROW(build("curve", {{"bones", 9.5}}), RigError);
}

TEST(CurveSpine, WarnsOfVeryUnequalBonesAndStaysFinite) {  // R6
  const auto curve = build("curve", {}, {.joint = {{0, 0, 0}, {0, 1, 0}, {0, 11, 0}, {0, 12, 0}}});
  EXPECT_FALSE(curve->rest().flags.empty());
  for (const auto& pose : {pose_b(), pose_e(), pose_f()}) {
    for (const dvec3& p : curve->solve(pose).position) EXPECT_TRUE(std::isfinite(glm::length(p)));
  }
  EXPECT_TRUE(build("curve")->rest().flags.empty());
}

TEST(CurveSpine, BuildsOnCharactersChainsOfThreeToTwentyJoints) {
  for (int joints = 3; joints <= 20; ++joints) {
    RestChain chain;
    for (int i = 0; i < joints; ++i) {
      const double s = double(i) / (joints - 1);
      chain.joint.push_back({0.01 * std::sin(9 * s), 1 + 0.5 * s, 0.06 * std::sin(5 * s)});
    }
    const auto curve = build("curve", {}, chain);
    const SpinePose pose = curve->solve(pose_e());
    for (const dvec3& p : pose.position) EXPECT_TRUE(std::isfinite(glm::length(p)));
    EXPECT_LT(glm::length(curve->rest().position.front() - chain.joint.front()), 1e-12);
    EXPECT_LT(glm::length(curve->rest().position.back() - chain.joint.back()), 0.01);
  }
}

}  // namespace
}  // namespace backbend::solver
