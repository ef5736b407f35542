// The peers, spline IK and the matrix blend: they must fail where the originals do, and say how far
// off that is. Facts: research/spine.md S6.1, S6.3, S6.5, S6.6.
#include <algorithm>
#include <cmath>

#include "solver/curves/curve.h"
#include "solver/rig/option_reader.h"
#include "tests/solver/rig_fixture.h"

namespace backbend::solver {
namespace {

using namespace rigs;

std::vector<double> chest(const SpineSystem& system, const std::string& axis, double deg) {
  std::vector<double> control = rest_controls(system);
  control[channel(system, "chest." + axis)] = radians(deg);
  return control;
}

/// What the default rig's chest control makes of its curve when it is turned about X.
Curve curve_of(double deg) {
  const double a = radians(deg);
  return Curve::bezier({dvec3(0, 0, 0),
                        {0, 2.4, 0},
                        dvec3(0, 6, 0) - 2.4 * dvec3(0, std::cos(a), std::sin(a)),
                        {0, 6, 0}});
}

const Options kNoScale{{"y_scale_mode", "none"}};

TEST(SplineIk, JointsMarchAlongTheCurveAtFixedBoneLength) {
  const auto ik = build("spline_ik", kNoScale);
  for (double deg = -170.0; deg <= 170.0; deg += 17.0) {
    const SpinePose pose = ik->solve(chest(*ik, "rz", deg));
    const Curve curve = curve_of(deg);
    for (std::size_t k = 0; k <= 10; ++k) {
      if (k > 0) {
        EXPECT_NEAR(glm::length(pose.position[k] - pose.position[k - 1]), 0.6, 1e-9);
      }
      const dvec3 nearest = curve.point(curve.closest_parameter(pose.position[k]));
      EXPECT_NEAR(glm::length(pose.position[k] - nearest), 0.0, 1e-7);
    }
    EXPECT_NEAR(measure(pose, "curve_length"), curve.length(), 1e-9);
  }
}

TEST(SplineIk, TheTipMissesTheControlAsSoonAsTheCurveBends) {
  const auto ik = build("spline_ik", kNoScale);
  EXPECT_GT(measure(ik->solve(chest(*ik, "rz", -90.0)), "tip_gap"), 0.5);
  std::vector<double> compressed = rest_controls(*ik);
  compressed[channel(*ik, "chest_move.y")] = -2.0;
  const SpinePose pose = ik->solve(compressed);
  EXPECT_NEAR(measure(pose, "tip_gap"), 2.0, 1e-9);  // straight on past the end
  EXPECT_FALSE(pose.flags.empty());
}

TEST(SplineIk, FitCurveStretchesTheBonesOverAllOfTheCurve) {
  const auto ik = build("spline_ik");  // as Blender's constraint, unless told otherwise
  for (double deg = -170.0; deg <= 170.0; deg += 17.0) {
    const SpinePose pose = ik->solve(chest(*ik, "rz", deg));
    const Curve curve = curve_of(deg);
    for (std::size_t k = 0; k <= 10; ++k)
      expect_near(pose.position[k], curve.at_fraction(double(k) / 10.0).position, 1e-9);
    EXPECT_NEAR(measure(pose, "tip_gap"), 0.0, 1e-9);
    EXPECT_NEAR(measure(pose, "used_length"), curve.length(), 1e-9);
    const auto meant = ik->intended_curve(chest(*ik, "rz", deg), 11);
    for (std::size_t k = 0; k <= 10; ++k) expect_near(meant[k], pose.position[k], 1e-9);
  }
}

TEST(SplineIk, MayasTwistComesWithMayasLengths) {
  const auto ik = build("spline_ik", {{"twist", "spread"}});
  EXPECT_EQ(ik->options().at("y_scale_mode"), OptionValue("none"));
  EXPECT_EQ(build("spline_ik")->options().at("y_scale_mode"), OptionValue("fit_curve"));
  const auto fitted = build("spline_ik", {{"twist", "spread"}, {"y_scale_mode", "fit_curve"}});
  EXPECT_GT(measure(ik->solve(chest(*ik, "rz", -90.0)), "tip_gap"), 0.5);
  EXPECT_NEAR(measure(fitted->solve(chest(*fitted, "rz", -90.0)), "tip_gap"), 0.0, 1e-9);
}

TEST(SplineIk, ABoneThatAFoldedCurveLeavesNoLengthDeclaresIt) {
  // One bone over a loop: its ends meet where the chest passes the hips, and it turns right round.
  const auto ik = build("spline_ik", {{"bones", 1.0}});
  std::vector<double> control = chest(*ik, "rz", 120.0);
  const auto at = [&](double above) {
    control[channel(*ik, "chest_move.y")] = above - 6.0;
    return ik->solve(control);
  };
  EXPECT_GT(turn_between_deg(at(1e-4), at(-1e-4), 0), 179.0);
  EXPECT_LT(at(1e-4).flip_margin[0], 1e-6);
  EXPECT_GT(at(6.0).flip_margin[0], 1.0);
  EXPECT_LT(at(0.5).flip_margin[0], at(1.5).flip_margin[0]);
}

TEST(SplineIk, FkRollLosesTheChestsTwist) {
  const auto ik = build("spline_ik");
  const SpinePose pose = ik->solve(chest(*ik, "rx", 90.0));
  for (const dquat& q : pose.turn) EXPECT_LE(angle_between(q, kNoTurn), 1e-12);
  EXPECT_NEAR(measure(pose, "chest_gap_deg"), 90.0, 1e-9);
}

TEST(SplineIk, SpreadTwistIsEvenUpToHalfATurnAndJumpsThere) {
  const auto ik = build("spline_ik", {{"twist", "spread"}});
  const SpinePose pose = ik->solve(chest(*ik, "rx", 90.0));
  for (std::size_t k = 0; k < 10; ++k) {
    EXPECT_NEAR(turn_between_deg(pose, ik->rest(), k), 10.0 * double(k), 1e-9);
  }
  // Bone k of ten jumps by 360 k / 9, modulo a whole turn; the first and the last do not.
  const auto jumps = find_jumps(*ik, rest_controls(*ik), "chest.rx", 170.0, 190.0, 1.0);
  std::vector<double> size(11, 0.0);
  for (const Jump& j : jumps) {
    EXPECT_NEAR(j.at_deg, 180.0, 1e-5);
    size[j.joint] = j.size_deg;
  }
  for (std::size_t k = 0; k < 10; ++k) {
    const double all = 360.0 * double(k) / 9.0;
    EXPECT_NEAR(size[k], std::min(all, 360.0 - all), 1e-3) << k;
  }
}

TEST(SplineIk, OneBoneTakesAllOfTheChestsTwist) {
  const auto ik = build("spline_ik", {{"twist", "spread"}, {"bones", 1.0}});
  const SpinePose pose = ik->solve(chest(*ik, "rx", 40.0));
  EXPECT_NEAR(turn_between_deg(pose, ik->rest(), 0), 40.0, 1e-9);
  EXPECT_NEAR(measure(pose, "chest_gap_deg"), 0.0, 1e-9);
}

TEST(SplineIk, MarginIsTheWayLeftToTheJump) {
  const auto ik = build("spline_ik", {{"twist", "spread"}});
  for (const double deg : {30.0, 100.0, 179.0}) {
    const SpinePose pose = ik->solve(chest(*ik, "rx", deg));
    EXPECT_NEAR(degrees(pose.flip_margin[5]), 180.0 - deg, 1e-9);
    EXPECT_NEAR(degrees(pose.flip_margin[0]), 180.0, 1e-9);  // keeps the hips' roll
    EXPECT_NEAR(measure(pose, "flip_margin_deg"), 180.0 - deg, 1e-9);
  }
}

TEST(SplineIk, ACollapsedCurveIsFinite) {
  const auto ik = build("spline_ik", {{"depth", std::vector<double>{0.0, 0.0}}});
  std::vector<double> control = rest_controls(*ik);
  control[channel(*ik, "chest_move.y")] = -6.0;
  const SpinePose pose = ik->solve(control);
  for (const dvec3& p : pose.position) EXPECT_TRUE(std::isfinite(glm::length(p)));
  for (const dquat& q : pose.turn) EXPECT_NEAR(glm::length(q), 1.0, 1e-12);
}

TEST(MatrixBlend, RestMeasuresWhatThePoseBesideItDoes) {
  for (const char* style : {"rigify", "mgear"}) {
    const auto blend = build("matrix_blend", {{"style", style}});
    std::vector<double> control = rest_controls(*blend);
    const SpinePose rest = blend->solve(control);
    control[channel(*blend, "chest.rx")] = 1e-9;
    const SpinePose beside = blend->solve(control);
    ASSERT_EQ(rest.flip_margin.size(), beside.flip_margin.size());
    for (std::size_t k = 0; k < rest.flip_margin.size(); ++k)
      EXPECT_NEAR(rest.flip_margin[k], beside.flip_margin[k], 1e-8) << style << " " << k;
    for (const Measure& each : rest.measures)
      EXPECT_NEAR(each.value, measure(beside, each.name), 1e-6) << style << " " << each.name;
  }
}

const Options kOneChain{{"pivot_pos", 0.0}};

TEST(MatrixBlend, OneChainSharesTheTurnEvenly) {
  const auto blend = build("matrix_blend", kOneChain);
  for (const char* axis : {"rx", "ry", "rz"}) {
    const SpinePose pose = blend->solve(chest(*blend, axis, 120.0));
    for (std::size_t k = 0; k < 10; ++k) {
      EXPECT_NEAR(turn_between_deg(pose, blend->rest(), k), 12.0 * double(k + 1), 1e-9);
    }
    EXPECT_NEAR(measure(pose, "chest_gap_deg"), 0.0, 1e-9);
    EXPECT_NEAR(measure(pose, "chain_length"), 6.0, 1e-9);
  }
}

TEST(MatrixBlend, AChestTurnLeavesTheHalfBelowThePivotStill) {
  const auto blend = build("matrix_blend");
  EXPECT_EQ(blend->options().at("pivot_pos"), OptionValue(5.0));
  for (const char* axis : {"rx", "ry", "rz"}) {
    const SpinePose pose = blend->solve(chest(*blend, axis, 120.0));
    for (std::size_t k = 0; k < 5; ++k) {
      expect_near(pose.position[k], blend->rest().position[k], 1e-12);
      EXPECT_NEAR(turn_between_deg(pose, blend->rest(), k), 0.0, 1e-9);
    }
    expect_near(pose.position[5], blend->rest().position[5], 1e-12);
    for (std::size_t k = 6; k < 10; ++k)
      EXPECT_NEAR(turn_between_deg(pose, blend->rest(), k), 24.0 * double(k - 4), 1e-9);
    EXPECT_NEAR(measure(pose, "chest_gap_deg"), 0.0, 1e-9);
    EXPECT_NEAR(measure(pose, "chain_length"), 6.0, 1e-9);
  }
  // The deform bone at the pivot bends with the half above, but takes half of its twist.
  EXPECT_NEAR(turn_between_deg(blend->solve(chest(*blend, "rx", 120.0)), blend->rest(), 5), 12.0,
              1e-9);
  EXPECT_NEAR(turn_between_deg(blend->solve(chest(*blend, "rz", 120.0)), blend->rest(), 5), 24.0,
              1e-9);
}

TEST(MatrixBlend, AHipTurnSwingsThePelvisAboutThePivotAndLeavesTheChest) {
  const auto blend = build("matrix_blend", {{"pivot_pos", 3.0}});
  std::vector<double> control = rest_controls(*blend);
  control[channel(*blend, "hip.rz")] = radians(30.0);
  const SpinePose pose = blend->solve(control);
  for (std::size_t k = 3; k <= 10; ++k)
    expect_near(pose.position[k], blend->rest().position[k], 1e-12);
  EXPECT_NEAR(turn_between_deg(pose, blend->rest(), 0), 30.0, 1e-9);
  // Twist of a joint is that of the bone below it, bend its own: 30, 20 and 10 degrees.
  dvec3 at = blend->rest().position[3];
  for (const double deg : {10.0, 20.0, 30.0})
    at -= 0.6 * dvec3(0, std::cos(radians(deg)), std::sin(radians(deg)));
  expect_near(pose.position[0], at, 1e-9);
  expect_near(pose.hip.posed_origin, at, 1e-9);
}

TEST(MatrixBlend, RigifyKeepsADrawnChainWithItsOwnBones) {
  const RestChain drawn{
      .joint = {{0, 0, 0}, {0, 1, 0.4}, {0, 2.5, 0.6}, {0, 4.5, 0}, {0, 6, -0.4}}};
  for (const double pivot : {0.0, 2.0}) {
    const auto blend = build("matrix_blend", {{"bones", 4.0}, {"pivot_pos", pivot}}, drawn);
    EXPECT_EQ(blend->rest().position, drawn.joint);
    const SpinePose pose = blend->solve(chest(*blend, "rz", -90.0));
    for (std::size_t k = 0; k < 4; ++k)
      EXPECT_NEAR(glm::length(pose.position[k + 1] - pose.position[k]),
                  glm::length(drawn.joint[k + 1] - drawn.joint[k]), 1e-9);
    EXPECT_NEAR(blend->arc_fraction()[1],
                glm::length(drawn.joint[1]) / measure(blend->rest(), "chain_length"), 1e-9);
  }
  // Another count is cut from it at equal steps along it.
  const auto finer = build("matrix_blend", {{"bones", 8.0}}, drawn);
  EXPECT_GT(finer->rest().position[3].z, 0.3);
  EXPECT_EQ(finer->rest().position.back(), drawn.joint.back());
}

TEST(MatrixBlend, MovesOfAControlAreSharedOutInItsHalf) {
  const auto blend = build("matrix_blend", {{"pivot_pos", 4.0}});
  std::vector<double> control = rest_controls(*blend);
  control[channel(*blend, "chest_move.y")] = 1.2;
  const SpinePose pose = blend->solve(control);
  for (std::size_t k = 0; k < 4; ++k)
    expect_near(pose.position[k], blend->rest().position[k], 1e-12);
  // The pivot stands half-way between the halves' first joints, of which one moves by a sixth.
  EXPECT_NEAR(pose.position[4].y, 2.4 + 0.1, 1e-12);
  EXPECT_NEAR(pose.position[5].y, 3.0 + 0.4, 1e-12);
  EXPECT_NEAR(pose.position[10].y, 7.2, 1e-12);
}

TEST(MatrixBlend, RefusesAPivotThatRigifyWould) {
  EXPECT_THROW(build("matrix_blend", {{"pivot_pos", 10.0}}), OptionError);
  EXPECT_THROW(build("matrix_blend", {{"pivot_pos", -1.0}}), OptionError);
  EXPECT_THROW(build("matrix_blend", {{"bones", 2.0}, {"pivot_pos", 1.0}}), OptionError);
  EXPECT_THROW(build("matrix_blend", {{"style", "mgear"}, {"pivot_pos", 5.0}}), OptionError);
  EXPECT_EQ(build("matrix_blend", {{"bones", 2.0}})->options().at("pivot_pos"), OptionValue(0.0));
}

TEST(MatrixBlend, TheFineChainGoesWhereTheBonesGo) {
  // Many bones are the fine chain itself; a pivot between two of its points is met, too.
  for (const double pivot : {0.0, 100.0, 67.0}) {
    const auto blend = build("matrix_blend", {{"bones", 200.0}, {"pivot_pos", pivot}}, curved());
    std::vector<double> control = chest(*blend, "rz", -100.0);
    control[channel(*blend, "hip.rz")] = radians(20.0);
    control[channel(*blend, "chest_move.y")] = 0.5;
    const SpinePose pose = blend->solve(control);
    const auto fine = blend->intended_curve(control, 101);
    for (std::size_t i = 0; i <= 100; ++i) expect_near(fine[i], pose.position[2 * i], 0.02);
  }
}

TEST(MatrixBlend, TheFineChainBendsAsTheJointsDoButBeginsSmoothly) {
  const auto blend = build("matrix_blend");
  const auto fine = blend->intended_curve(chest(*blend, "rz", -120.0), 1001);
  for (std::size_t k = 1; k < 10; ++k) {
    const dvec3 below = fine[100 * k] - fine[100 * (k - 1)],
                above = fine[100 * (k + 1)] - fine[100 * k];
    // 24 degrees at each joint from the pivot up; an eighth of it already at the joint below.
    const double turn = k < 4 ? 0.0 : k == 4 ? 3.0 : k == 5 ? 21.0 : 24.0;
    EXPECT_NEAR(degrees(angle_between(below, above)), turn, 0.1) << k;
  }
}

TEST(MatrixBlend, TheFineChainGoesOnPastItsOutermostMiddles) {
  // Bones of 1, 3, 1 and 1; from the middle of the first to that of the second is 2, so at the
  // hips, half a length before, a quarter of a third more than hip's own turn is meant.
  const RestChain drawn{.joint = {{0, 0, 0}, {0, 1, 0}, {0, 4, 0}, {0, 5, 0}, {0, 6, 0}}};
  const auto blend = build("matrix_blend", {{"bones", 4.0}, {"pivot_pos", 3.0}}, drawn);
  std::vector<double> control = rest_controls(*blend);
  control[channel(*blend, "hip.rz")] = radians(90.0);
  const auto fine = blend->intended_curve(control, 6001);
  EXPECT_NEAR(degrees(angle_between(fine[1] - fine[0], dvec3(0, 1, 0))), 97.5, 0.1);
}

TEST(MatrixBlend, HalvesThatAreHalfATurnApartAtThePivotDeclareIt) {
  // Of three bones: below the pivot all of hip's turn, above it half of chest's.
  const auto blend = build("matrix_blend", {{"bones", 3.0}, {"pivot_pos", 1.0}});
  std::vector<double> control = chest(*blend, "rz", -100.0);
  control[channel(*blend, "hip.rz")] = radians(120.0);
  const SpinePose pose = blend->solve(control);
  ASSERT_EQ(pose.flip_margin.size(), 4u);
  EXPECT_NEAR(degrees(pose.flip_margin[1]), 10.0, 1e-9);
}

TEST(MatrixBlend, EveryFractionJumpsAtHalfATurnOfAnyAxis) {
  for (const char* axis : {"rx", "ry", "rz"}) {
    const auto blend = build("matrix_blend", kOneChain);
    const auto jumps =
        find_jumps(*blend, rest_controls(*blend), std::string("chest.") + axis, 170.0, 190.0, 1.0);
    std::vector<double> size(11, 0.0);
    for (const Jump& j : jumps) {
      EXPECT_NEAR(j.at_deg, 180.0, 1e-5);
      size[j.joint] = j.size_deg;
    }
    for (std::size_t k = 0; k < 10; ++k) {
      const double all = 36.0 * double(k + 1);
      EXPECT_NEAR(size[k], std::min(all, 360.0 - all), 1e-3) << axis << " bone " << k;
    }
    EXPECT_NEAR(degrees(blend->solve(chest(*blend, axis, 100.0)).flip_margin[4]), 80.0, 1e-9);
  }
}

TEST(MatrixBlend, WithAPivotOnlyItsHalfJumpsAtHalfATurn) {
  // Of ten bones, pivot 5: how much of a control's turn each bone has. About the spine a bone of
  // the lower half has that of the joint beyond its foot, and the pivot's bone that of the half-way
  // joint.
  const std::map<std::string, std::vector<double>> share = {
      {"chest bend", {0, 0, 0, 0, 0, 0.2, 0.4, 0.6, 0.8, 1, 1}},
      {"chest twist", {0, 0, 0, 0, 0, 0.1, 0.4, 0.6, 0.8, 1, 1}},
      {"hip bend", {1, 0.8, 0.6, 0.4, 0.2, 0, 0, 0, 0, 0, 0}},
      {"hip twist", {1, 1, 0.8, 0.6, 0.4, 0.1, 0, 0, 0, 0, 0}}};
  const auto blend = build("matrix_blend");
  for (const std::string control : {"chest", "hip"}) {
    for (const std::string axis : {".rx", ".ry", ".rz"}) {
      const auto& part = share.at(control + (axis == ".rx" ? " twist" : " bend"));
      std::vector<double> size(11, 0.0), at = rest_controls(*blend);
      for (const Jump& j : find_jumps(*blend, at, control + axis, 170.0, 190.0, 1.0)) {
        EXPECT_NEAR(j.at_deg, 180.0, 1e-5);
        size[j.joint] = j.size_deg;
      }
      at[channel(*blend, control + axis)] = radians(100.0);
      const SpinePose pose = blend->solve(at);
      for (std::size_t k = 0; k < 11; ++k) {
        SCOPED_TRACE(control + axis + " of joint " + std::to_string(k));
        EXPECT_NEAR(turn_between_deg(pose, blend->rest(), k), 100.0 * part[k], 1e-9);
        EXPECT_NEAR(size[k], degrees(std::abs(wrap(radians(360.0 * part[k])))), 1e-3);
        const bool fraction = part[k] > 0.0 && part[k] < 1.0;
        if (fraction) {
          EXPECT_NEAR(degrees(pose.flip_margin[k]), 80.0, 1e-9);
        }
      }
      at[channel(*blend, control + axis)] = kPi;
      EXPECT_FALSE(blend->solve(at).flags.empty());
    }
  }
}

TEST(MatrixBlend, MgearRidesItsCurveWithExactEnds) {
  const auto blend = build("matrix_blend", {{"style", "mgear"}});
  for (const char* axis : {"rx", "ry", "rz"}) {
    const SpinePose pose = blend->solve(chest(*blend, axis, 70.0));
    EXPECT_LE(angle_between(pose.turn.front(), pose.hip.turn), 1e-9);
    EXPECT_LE(angle_between(pose.turn.back(), pose.chest.turn), 1e-9);
    EXPECT_EQ(measure(pose, "tip_gap"), 0.0);
  }
}

TEST(MatrixBlend, MgearsEndsDoNotJumpWhereTheBlendDoes) {
  const auto blend = build("matrix_blend", {{"style", "mgear"}});
  const SpinePose pose = blend->solve(chest(*blend, "rx", 170.0));  // the curve stays straight
  for (std::size_t k = 0; k < pose.flip_margin.size(); ++k) {
    const bool end = k == 0 || k + 1 == pose.flip_margin.size();
    EXPECT_NEAR(degrees(pose.flip_margin[k]), end ? 90.0 : 10.0, 1e-9) << k;
  }
}

TEST(MatrixBlend, MgearsUpVectorFlipsInASideBend) {
  // The side axis leans with the blend while the curve stays: sideways they meet, as Isner's front
  // axis does in a backbend.
  const auto blend = build("matrix_blend", {{"style", "mgear"}});
  EXPECT_TRUE(find_jumps(*blend, rest_controls(*blend), "chest.rz", 0.0, -170.0, -1.0).empty());
  const auto jumps = find_jumps(*blend, rest_controls(*blend), "chest.ry", 0.0, 170.0, 1.0);
  ASSERT_FALSE(jumps.empty());
  for (const Jump& j : jumps) {
    EXPECT_NEAR(j.size_deg, 180.0, 0.1);
    std::vector<double> at = chest(*blend, "ry", j.at_deg);
    EXPECT_LT(blend->solve(at).flip_margin[j.joint], 1e-6);
  }
}

TEST(MatrixBlend, StandsStillAtHalfATurnAndSaysSo) {
  for (const char* style : {"rigify", "mgear"}) {
    const auto blend = build("matrix_blend", {{"style", style}});
    const SpinePose pose = blend->solve(chest(*blend, "rx", 180.0));
    for (const dvec3& p : pose.position) EXPECT_TRUE(std::isfinite(glm::length(p)));
    EXPECT_FALSE(pose.flags.empty());
  }
}

TEST(Peers, EvenPassesWhereTheyJump) {
  const auto even = build("even");
  for (const char* axis : {"top.rx", "top.ry", "top.rz"}) {
    EXPECT_TRUE(find_jumps(*even, rest_controls(*even), axis, -400.0, 400.0, 2.0, 2.5).empty());
  }
}

TEST(Peers, SpreadMovesTheChestToTheThreeBoneTip) {  // spec 4.8
  const BodyPose body{.extension = 1.2, .side = 0.3};
  const auto bones = build("three_bone");
  const dvec3 tip = bones->solve(bones->controls_for(body, Mapping::spread)).position.back();
  for (const char* system : {"stretchy", "spline_ik"}) {
    const auto rig = build(system);
    expect_near(rig->solve(rig->controls_for(body, Mapping::spread)).chest.posed_origin, tip,
                1e-12);
    expect_near(rig->solve(rig->controls_for(body, Mapping::chest)).chest.posed_origin, {0, 6, 0},
                1e-12);
  }
}

}  // namespace
}  // namespace backbend::solver
