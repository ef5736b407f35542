// The emulated Isner spine. It must flip where the real one does: research/spine.md 1.6 and 13,
// spec 4.3, R11 .. R19.
#include <algorithm>
#include <cmath>

#include "tests/solver/rig_fixture.h"

namespace backbend::solver {
namespace {

using namespace rigs;

/// A unit spine, as in the measurements that the expected angles come from.
RestChain unit_chain() { return {.joint = {{0, 0, 0}, {0, 1, 0}}}; }

/// First flip of each joint while the chest pitches back in place, degrees; 0 where none is.
std::vector<double> first_flips(const SpineSystem& system, double to = -185.0) {
  std::vector<double> first(system.joint_names().size(), 0.0);
  for (const Jump& j : find_jumps(system, rest_controls(system), "chest.rz", 0.0, to, -0.5, 90.0)) {
    if (first[j.joint] == 0.0) first[j.joint] = -j.at_deg;
  }
  return first;
}

constexpr double kFlipTolerance = 0.3;  // degrees, from the specification

TEST(Isner, FixedLengthFlipsVertebraAfterVertebraAndTheArmsWithTheTopOne) {
  const auto flips = first_flips(*build("isner", {}, unit_chain()));
  ASSERT_EQ(flips.size(), 6u);  // five vertebrae and the top one
  EXPECT_EQ(flips[0], 0.0);
  EXPECT_EQ(flips[1], 0.0);
  EXPECT_NEAR(flips[2], 180.0, kFlipTolerance);
  EXPECT_NEAR(flips[3], 116.2, kFlipTolerance);
  EXPECT_NEAR(flips[4], 100.9, kFlipTolerance);
  EXPECT_NEAR(flips[5], 114.3, kFlipTolerance);
}

TEST(Isner, ArmsFlipExactlyWhenTheTopVertebraDoes) {
  const auto system = build("isner", {}, unit_chain());
  auto control = rest_controls(*system);
  control[channel(*system, "chest.rz")] = radians(-114.0);
  const SpinePose before = system->solve(control);
  control[channel(*system, "chest.rz")] = radians(-114.6);
  const SpinePose after = system->solve(control);
  EXPECT_GT(degrees(angle_between(before.arms.turn, after.arms.turn)), 170.0);
  EXPECT_LT(degrees(angle_between(before.chest.turn, after.chest.turn)), 1.0);
}

TEST(Isner, AFlipIsHalfATurnAboutTheTangent) {
  const auto system = build("isner", {}, unit_chain());
  for (const Jump& j :
       find_jumps(*system, rest_controls(*system), "chest.rz", 0.0, -179.0, -0.5, 90.0)) {
    EXPECT_NEAR(j.size_deg, 180.0, 1e-3) << system->joint_names()[j.joint];
  }
}

TEST(Isner, StretchyFlipsOnlyTheTwoUpperVertebraeAndNeverTheTopOne) {
  const auto flips = first_flips(*build("isner", {{"length", "stretchy"}}, unit_chain()));
  EXPECT_EQ(flips[0], 0.0);
  EXPECT_EQ(flips[1], 0.0);
  EXPECT_NEAR(flips[2], 180.0, kFlipTolerance);
  EXPECT_NEAR(flips[3], 120.4, kFlipTolerance);
  EXPECT_NEAR(flips[4], 119.6, kFlipTolerance);
  EXPECT_EQ(flips[5], 0.0);
}

TEST(Isner, ForwardBendsFlipAtTheSameAngles) {
  const auto system = build("isner", {}, unit_chain());
  std::vector<double> first(6, 0.0);
  for (const Jump& j :
       find_jumps(*system, rest_controls(*system), "chest.rz", 0.0, 179.0, 0.5, 90.0)) {
    if (first[j.joint] == 0.0) first[j.joint] = j.at_deg;
  }
  EXPECT_NEAR(first[4], 100.9, kFlipTolerance);
  EXPECT_NEAR(first[5], 114.3, kFlipTolerance);
  EXPECT_NEAR(first[3], 116.2, kFlipTolerance);
}

// The sensitivity table of research/spine.md 1.6, read off there in whole degrees.
struct Sensitivity {
  double depth;
  int vertebrae;
  const char* length;
  std::vector<double> flips;  // hip first, the top vertebra last; 0: none
};

TEST(Isner, FlipsMoveWithDepthAndCountAsTabulated) {
  const Sensitivity table[] = {
      {0.20, 5, "fixed", {0, 0, 180, 129, 109, 123}},
      {0.20, 5, "stretchy", {0, 0, 180, 130, 113, 0}},
      {0.33, 5, "fixed", {0, 0, 180, 121, 105, 118}},
      {0.33, 5, "stretchy", {0, 0, 180, 124, 117, 0}},
      {0.40, 3, "fixed", {0, 180, 105, 115}},
      {0.40, 3, "stretchy", {0, 180, 114, 0}},
      {0.48, 5, "fixed", {0, 0, 180, 111, 96, 110}},
      {0.48, 5, "stretchy", {0, 0, 180, 116, 125, 0}},
      {0.40, 10, "fixed", {0, 0, 0, 0, 0, 155, 123, 108, 102, 103, 115}},
  };
  for (const Sensitivity& row : table) {
    const auto system = build("isner",
                              {{"depth", std::vector<double>{row.depth, row.depth}},
                               {"vertebrae", double(row.vertebrae)},
                               {"length", row.length}},
                              unit_chain());
    const auto flips = first_flips(*system);
    ASSERT_EQ(flips.size(), row.flips.size());
    for (std::size_t i = 0; i < flips.size(); ++i) {
      EXPECT_NEAR(flips[i], row.flips[i], 1.05)
          << "depth " << row.depth << " " << row.length << " joint " << i;
    }
  }
}

TEST(Isner, SideBendNeverFlips) {  // the up vector stays perpendicular to the bending plane
  const auto system = build("isner", {}, unit_chain());
  const auto side = [&](double deg) {
    auto control = rest_controls(*system);
    control[channel(*system, "chest.ry")] = radians(deg);
    return control;
  };
  // Below half a turn; there the slerp's two ways round are equally long (the jumps of twist).
  EXPECT_LT(largest_step_deg(*system, side, 0.0, -179.5, -0.5), 1.0);
}

TEST(Isner, TwistPastHalfATurnJumpsEveryVertebraBy360TimesItsFraction) {  // R18
  const auto system = build("isner", {}, unit_chain());
  const auto jumps = find_jumps(*system, rest_controls(*system), "chest.rx", 0.0, 200.0, 0.5);
  const double expected[] = {60, 120, 180, 120, 60};  // min(360 t, 360 - 360 t), t = (i + 1) / 6
  ASSERT_EQ(jumps.size(), 5u);
  for (const Jump& j : jumps) {
    EXPECT_NEAR(j.at_deg, 180.0, 1e-6);
    ASSERT_LT(j.joint, 5u) << "the top vertebra follows the chest";
    EXPECT_NEAR(j.size_deg, expected[j.joint], 1e-4);
  }
}

TEST(Isner, RawSlerpMovesTheTwistJumpFrom180To360) {
  const auto system = build("isner", {{"slerp", "raw"}}, unit_chain());
  const auto jumps = find_jumps(*system, rest_controls(*system), "chest.rx", 0.0, 400.0, 0.5);
  // At 360 exactly both quaternions are one rotation and the hip's is returned: one jump on to the
  // pose, one off it.
  ASSERT_EQ(jumps.size(), 10u);
  const double expected[] = {60, 120, 180, 120, 60};
  for (const Jump& j : jumps) {
    EXPECT_NEAR(j.at_deg, 360.0, 1e-4);
    EXPECT_NEAR(j.size_deg, expected[j.joint], 1e-3);
  }
}

TEST(Isner,
     ElevenVertebraeFlipInTheUpperHalfOnly) {  // R19, oracle: joints 5 .. 9, first at 115 .. 222
  const auto system = build("isner", {{"vertebrae", 11.0},
                                      {"placement", "inclusive"},
                                      {"depth", std::vector<double>{1.0 / 3, 1.0 / 3}},
                                      {"length", "stretchy"}});
  std::vector<double> first(11, 0.0);
  for (const Jump& j :
       find_jumps(*system, rest_controls(*system), "chest.rz", 0.0, -270.0, -1.0, 150.0)) {
    if (first[j.joint] == 0.0 && j.size_deg > 179.0) first[j.joint] = -j.at_deg;
  }
  for (int i : {0, 1, 2, 3, 4, 10}) EXPECT_EQ(first[i], 0.0) << i;
  for (int i : {5, 6, 7, 8, 9}) {
    EXPECT_GE(std::ceil(first[i]), 115.0) << i;  // the oracle walks in whole degrees
    EXPECT_LE(std::ceil(first[i]), 222.0) << i;
  }
}

TEST(Isner, CurveLengthGrowsWithChestPitchAsTabulated) {  // research/spine.md 13.4
  const auto system = build("isner", {}, unit_chain());
  const double table[][2] = {
      {30, 1.0232}, {60, 1.0775}, {90, 1.1351}, {120, 1.1754}, {150, 1.1898}};
  for (const auto& [deg, ratio] : table) {
    auto control = rest_controls(*system);
    control[channel(*system, "chest.rz")] = radians(-deg);
    EXPECT_NEAR(measure(system->solve(control), "curve_length"), ratio, 5e-5) << deg;
  }
}

TEST(Isner, RestIsAStraightRowOfVertebrae) {  // R11
  const auto system = build("isner", {{"vertebrae", 9.0}});
  for (std::size_t i = 0; i < 10; ++i) {
    expect_near(system->rest().position[i], {0, 0.6 * double(i + 1), 0}, 1e-12);
  }
}

TEST(Isner, EndsTakeTheHipsAndTheChestsOrientation) {  // R12
  const auto system =
      build("isner", {{"vertebrae", 11.0}, {"placement", "inclusive"}, {"length", "stretchy"}});
  auto control = rest_controls(*system);
  const double deg[] = {15, -20, 40, 30, 25, -70};
  for (int i = 0; i < 6; ++i) control[std::size_t(i)] = radians(deg[i]);
  for (const char* aim : {"project", "none", "shortest_arc"}) {
    const auto s = build(
        "isner",
        {{"vertebrae", 11.0}, {"placement", "inclusive"}, {"length", "stretchy"}, {"aim", aim}});
    const SpinePose pose = s->solve(control);
    EXPECT_LT(degrees(angle_between(pose.turn.front(), pose.hip.turn)), 1e-6) << aim;
    EXPECT_LT(degrees(angle_between(pose.turn.back(), pose.chest.turn)), 1e-6) << aim;
  }
}

TEST(Isner, WithoutDepthTheSpineIsStraightWhateverTheControlsTurn) {  // R13
  const auto system =
      build("isner", {{"depth", std::vector<double>{0.0, 0.0}}, {"vertebrae", 7.0}});
  auto control = rest_controls(*system);
  control[channel(*system, "hip.ry")] = radians(40);
  control[channel(*system, "chest.rz")] = radians(-100);
  const SpinePose pose = system->solve(control);
  for (const dvec3& p : pose.position) {
    EXPECT_NEAR(p.x, 0.0, 1e-12);
    EXPECT_NEAR(p.z, 0.0, 1e-12);
  }
}

TEST(Isner, CurveMidpointObeysTheBezierIdentity) {  // R13: (H + C)/2 + 3/8 d (Xh - Xc)
  const auto system =
      build("isner", {{"vertebrae", 3.0}, {"placement", "inclusive"}, {"length", "stretchy"}});
  auto control = rest_controls(*system);
  control[channel(*system, "hip.rz")] = radians(50);
  control[channel(*system, "chest.rz")] = radians(-50);
  const SpinePose pose = system->solve(control);  // symmetric, so mid arc is mid parameter
  const dvec3 xh = pose.hip.turn * dvec3(0, 1, 0), xc = pose.chest.turn * dvec3(0, 1, 0);
  const double depth = 0.4 * 6.0;
  expect_near(pose.position[1], dvec3(0, 3, 0) + 3.0 / 8.0 * depth * (xh - xc), 1e-9);
}

TEST(Isner, FixedLengthReachesTowardTheChestAsFarAsItCan) {  // R14
  const auto system = build("isner", {{"vertebrae", 9.0}});
  auto control = rest_controls(*system);
  control[channel(*system, "chest_move.y")] = 3.0;  // pulled straight to 9
  const SpinePose pulled = system->solve(control);
  expect_near(pulled.position.back(), {0, 6, 0}, 1e-9);
  EXPECT_NEAR(measure(pulled, "tip_gap"), 3.0, 1e-9);
  EXPECT_NEAR(measure(pulled, "used_length"), 6.0, 1e-9);
}

TEST(Isner, MarginIsTheAngleBetweenUpVectorAndTangentAndVanishesAtTheFlip) {
  const auto system = build("isner", {}, unit_chain());
  auto control = rest_controls(*system);
  const std::size_t pitch = channel(*system, "chest.rz");
  for (const Jump& j : find_jumps(*system, control, "chest.rz", 0.0, -179.0, -0.5, 90.0)) {
    control[pitch] = radians(j.at_deg);
    EXPECT_LT(degrees(system->solve(control).flip_margin[j.joint]), 1e-3);
    control[pitch] = radians(j.at_deg + 5.0);  // five degrees before it: within reach, not there
    const double before = degrees(system->solve(control).flip_margin[j.joint]);
    EXPECT_GT(before, 1.0);
    EXPECT_LT(before, 15.0);
  }
  control[pitch] = 0.0;
  for (const double margin : system->solve(control).flip_margin)
    EXPECT_NEAR(degrees(margin), 90.0, 1e-6);
}

TEST(Isner, MarginVanishesTowardsACusp) {  // the chest's depth runs out, and with it the direction
  const auto system = build("isner", {{"placement", "inclusive"}}, unit_chain());
  auto control = rest_controls(*system);
  control[channel(*system, "chest.rz")] = radians(-40.0);
  double before = kPi;
  for (const double depth : {0.02, 0.01, 0.005, 1e-3, 1e-6}) {
    control[channel(*system, "chest_depth")] = depth;
    const double margin = system->solve(control).flip_margin.back();
    EXPECT_LT(margin, before) << depth;
    before = margin;
  }
  EXPECT_LT(before, 1e-6);
  // Without any depth the spine is a straight line, which keeps its direction.
  const auto straight =
      build("isner", {{"placement", "inclusive"}, {"depth", std::vector<double>{0.0, 0.0}}},
            unit_chain());
  for (const double margin : straight->rest().flip_margin) EXPECT_NEAR(degrees(margin), 90.0, 1e-6);
}

TEST(Isner, ShortestArcAimHasNoUpVectorFlip) {  // research/spine.md 1.7, remedy R1
  const auto system = build("isner", {{"aim", "shortest_arc"}}, unit_chain());
  EXPECT_TRUE(
      find_jumps(*system, rest_controls(*system), "chest.rz", 0.0, -175.0, -0.5, 20.0).empty());
}

TEST(Isner, StandsStillInASingularPoseWithAFiniteAnswerAndSaysSo) {
  // A chest folded by half a turn on a spine without depth: tangent and up vector meet exactly.
  const auto system = build(
      "isner",
      {{"depth", std::vector<double>{0.0, 0.0}}, {"vertebrae", 3.0}, {"placement", "inclusive"}});
  auto control = rest_controls(*system);
  control[channel(*system, "chest.rz")] =
      radians(-180.0);  // middle vertebra's up vector lies on the line
  const SpinePose pose = system->solve(control);
  for (const dquat& q : pose.turn) EXPECT_NEAR(glm::length(q), 1.0, 1e-12);
  EXPECT_LT(*std::min_element(pose.flip_margin.begin(), pose.flip_margin.end()), 1e-6);
}

TEST(Isner, CollapsedSpineIsFiniteAndFlagged) {
  const auto system = build("isner", {{"depth", std::vector<double>{0.0, 0.0}}});
  auto control = rest_controls(*system);
  control[channel(*system, "chest_move.y")] = -6.0;
  const SpinePose pose = system->solve(control);
  for (const dvec3& p : pose.position) expect_near(p, {0, 0, 0}, 1e-12);
  for (const dquat& q : pose.turn) EXPECT_NEAR(glm::length(q), 1.0, 1e-12);
  EXPECT_FALSE(pose.flags.empty());
}

TEST(Isner, SpreadMovesTheChestToTheThreeBoneTip) {
  const auto system = build("isner");
  const auto fk = build("three_bone");
  const BodyPose body{.extension = radians(80), .side = radians(10), .twist = radians(20)};
  const auto control = system->controls_for(body, Mapping::spread);
  const SpinePose pose = system->solve(control);
  const SpinePose three = fk->solve(fk->controls_for(body, Mapping::spread));
  expect_near(pose.chest.posed_origin, three.position.back(), 1e-12);
  EXPECT_EQ(control[channel(*system, "chest.rz")], -radians(80));
  const auto in_place = system->controls_for(body, Mapping::chest);
  EXPECT_EQ(in_place[channel(*system, "chest_move.y")], 0.0);
}

}  // namespace
}  // namespace backbend::solver
