// The peers, spline IK and the matrix blend: they must fail where the originals do, and say how far
// off that is. Facts: research/spine.md S6.1, S6.3, S6.5, S6.6.
#include <algorithm>
#include <cmath>

#include "solver/curve.h"
#include "tests/solver/rig_fixture.h"

namespace backbend::solver {
namespace {

using namespace rigs;

std::vector<double> chest(const SpineSystem& system, const std::string& axis, double deg) {
  std::vector<double> control = rest_controls(system);
  control[channel(system, "chest." + axis)] = radians(deg);
  return control;
}

TEST(SplineIk, JointsMarchAlongTheCurveAtFixedBoneLength) {
  const auto ik = build("spline_ik");
  for (double deg = -170.0; deg <= 170.0; deg += 17.0) {
    const SpinePose pose = ik->solve(chest(*ik, "rz", deg));
    const double a = radians(deg);
    const Curve curve = Curve::bezier({dvec3(0, 0, 0),
                                       {0, 2.4, 0},
                                       dvec3(0, 6, 0) - 2.4 * dvec3(0, std::cos(a), std::sin(a)),
                                       {0, 6, 0}});
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
  const auto ik = build("spline_ik");
  EXPECT_GT(measure(ik->solve(chest(*ik, "rz", -90.0)), "tip_gap"), 0.5);
  std::vector<double> compressed = rest_controls(*ik);
  compressed[channel(*ik, "chest_move.y")] = -2.0;
  const SpinePose pose = ik->solve(compressed);
  EXPECT_NEAR(measure(pose, "tip_gap"), 2.0, 1e-9);  // straight on past the end
  EXPECT_FALSE(pose.flags.empty());
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

TEST(MatrixBlend, RigifySharesTheTurnEvenly) {
  const auto blend = build("matrix_blend");
  for (const char* axis : {"rx", "ry", "rz"}) {
    const SpinePose pose = blend->solve(chest(*blend, axis, 120.0));
    for (std::size_t k = 0; k < 10; ++k) {
      EXPECT_NEAR(turn_between_deg(pose, blend->rest(), k), 12.0 * double(k + 1), 1e-9);
    }
    EXPECT_NEAR(measure(pose, "chest_gap_deg"), 0.0, 1e-9);
    EXPECT_NEAR(measure(pose, "chain_length"), 6.0, 1e-9);
  }
}

TEST(MatrixBlend, EveryFractionJumpsAtHalfATurnOfAnyAxis) {
  for (const char* axis : {"rx", "ry", "rz"}) {
    const auto blend = build("matrix_blend");
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
