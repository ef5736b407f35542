// The neck's system controller, requirement by requirement (research/seeds.md 2h). Fixtures: the
// seed's fourteen vertebrae (head first, Z up), and NK-S, thirteen driven ones straight along -X.
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>

#include "solver/rig/solve_file.h"
#include "tests/solver/rig_fixture.h"
#include "tests/source_folder.h"

namespace backbend::solver {
namespace {

using namespace rigs;

const std::filesystem::path kAccept = source_folder() / "tests/accept";

SolveFile seed_neck(const std::string& rig = "", const std::string& pose = "") {
  return parse_solve_file("[rig]\nsystem = \"neck\"\n" + rig +
                              "\n[chain]\nrest = \"mSaurus_neck.json\"\n[pose]\n" + pose,
                          "neck.toml", kAccept);
}

SpinePose solved(const SolveFile& file) { return file.system->solve(file.control); }
SpinePose seed_pose(const std::string& pose) { return solved(seed_neck("", pose)); }

/// Fourteen identity frames, 10 apart; the fixed one at the origin, the head at (-130, 0, 0).
RestChain straight_neck() {
  RestChain chain;
  for (int j = 1; j <= 14; ++j) {
    RestFrame frame{"vert_" + std::to_string(j), glm::dmat4(1.0)};
    frame.rig_from_joint[3] = {-10.0 * (14 - j), 0.0, 0.0, 1.0};
    chain.frame.push_back(frame);
  }
  return chain;
}

SpinePose straight_pose(const std::vector<std::pair<std::string, double>>& deg,
                        Options options = {}) {
  const auto neck = build("neck", std::move(options), straight_neck());
  std::vector<double> control = rest_controls(*neck);
  for (const auto& [name, value] : deg) control[channel(*neck, name)] = radians(value);
  return neck->solve(control);
}

TEST(Neck, SeedHasThirteenDrivenVertebraeAndAFixedParent) {  // R88, R90
  const SolveFile file = seed_neck();
  const auto& rest = file.system->rest();
  ASSERT_EQ(rest.joint_count(), 14u);
  EXPECT_EQ(file.system->joint_names().front(), "mSaurus_C_vert_01");
  EXPECT_EQ(file.system->joint_parents()[0], 1);
  EXPECT_EQ(file.system->joint_parents()[13], -1);
  double sum = 0.0;
  for (int i = 0; i < 13; ++i) sum += glm::length(rest.position[i + 1] - rest.position[i]);
  EXPECT_NEAR(sum, 114.98536, 1e-4);
  EXPECT_NEAR(glm::length(rest.position[0] - rest.position[13]), 109.5476, 1e-4);
  EXPECT_NEAR(glm::length(rest.position[0] - rest.position[1]), 6.63433, 1e-4);
}

TEST(Neck, BonesRunAlongTheirParentsMinusXWithinThirteenDegrees) {  // R91
  const SolveFile file = seed_neck();
  // The stored rows are local axes; local X of the fixed parent points back, to world +Y.
  const auto& rest = file.system->rest().position;
  std::ifstream in(kAccept / "mSaurus_neck.json");
  const auto vertebrae = nlohmann::json::parse(in).at("vertebrae");
  double least = 180.0, most = 0.0;
  std::size_t worst = 0;
  for (std::size_t child = 0; child < 13; ++child) {
    const auto& x = vertebrae[child + 1].at("row1_x_axis");
    const dvec3 back(x[0], x[1], x[2]);
    const double off = degrees(angle_between(rest[child] - rest[child + 1], -back));
    least = std::min(least, off);
    if (off > most) most = off, worst = child;
  }
  EXPECT_NEAR(least, 1.25, 0.01);
  EXPECT_NEAR(most, 13.0524, 1e-3);
  EXPECT_EQ(file.system->joint_names()[worst], "mSaurus_C_vert_10");
}

TEST(Neck, FlatTransformsAndTheHierarchyAgree) {  // R110
  const SolveFile file = seed_neck();
  const SpinePose pose = seed_pose("base_z = 24\nbase_y = -20\ntop_y = 35\nroll = 45");
  const auto& rest = file.system->rest().position;
  for (std::size_t i = 0; i < 13; ++i) {
    const auto parent = std::size_t(file.system->joint_parents()[i]);
    // Local place and turn, taken from the flat pose and put back together under the parent.
    const dvec3 local =
        glm::conjugate(pose.turn[parent]) * (pose.position[i] - pose.position[parent]);
    expect_near(pose.position[parent] + pose.turn[parent] * local, pose.position[i], 1e-9);
    EXPECT_NEAR(glm::length(local), glm::length(rest[i] - rest[parent]), 1e-9);  // rigid links
  }
}

TEST(Neck, RestIsTheStoredFrames) {  // R94
  const SolveFile file = seed_neck();
  const SpinePose pose = solved(file);
  EXPECT_EQ(pose.position, file.system->rest().position);
  for (const dquat& q : pose.turn) EXPECT_EQ(q, kNoTurn);
}

TEST(Neck, FixedParentIsNeverMovedByTheControls) {  // R88, R96
  const SolveFile rest = seed_neck();
  const SpinePose pose = seed_pose("base_z = 30\nbase_y = 40\ntop_y = -20\nroll = 50");
  EXPECT_EQ(pose.position[13], rest.system->rest().position[13]);
  EXPECT_LE(angle_between(pose.turn[13], kNoTurn), 1e-15);
}

TEST(Neck, MovingTheParentCarriesTheWholeNeck) {  // R95, R112
  const SolveFile still = seed_neck("", "base_y = 20\nroll = 10");
  const SolveFile moved =
      seed_neck("", "base_y = 20\nroll = 10\nparent = [0, 0, 90]\nparent_move = [1, 2, 3]");
  const SpinePose a = solved(still), b = solved(moved);
  const dquat turn = b.turn[13];
  EXPECT_NEAR(degrees(angle_between(turn, kNoTurn)), 90.0, 1e-9);
  for (std::size_t i = 0; i < 14; ++i) {
    expect_near(b.position[i], b.position[13] + turn * (a.position[i] - a.position[13]), 1e-9);
    EXPECT_LE(angle_between(b.turn[i], turn * a.turn[i]), 1e-12);
  }
}

TEST(Neck, EachChannelAloneKeepsTheOthersPlanes) {  // R92
  for (const dvec3& p : straight_pose({{"base_z", 40.0}}).position) EXPECT_NEAR(p.z, 0.0, 1e-12);
  for (const dvec3& p : straight_pose({{"base_y", 40.0}, {"top_y", 20.0}}).position) {
    EXPECT_NEAR(p.y, 0.0, 1e-12);
  }
  EXPECT_EQ(straight_pose({{"roll", 90.0}}).position,
            build("neck", {}, straight_neck())->rest().position);
}

TEST(Neck, ChildTurnsAboutItsParentsPivot) {  // R96
  expect_near(seed_pose("base_y = 30").position[12], {-6.75497, -281.19384, 202.017766}, 1e-3);
}

TEST(Neck, LateralControlIsSharedByEighths) {  // R97, R98: thirteen eighths in all
  const SpinePose pose = straight_pose({{"base_z", 40.0}});
  expect_near(pose.position[0], {-100.902397, -70.652619, 0.0}, 1e-5);
  EXPECT_NEAR(degrees(angle_between(pose.turn[0], kNoTurn)), 65.0, 1e-9);
  // The closed form: running sums of five degrees.
  dvec3 head(0.0);
  for (int k = 1; k <= 13; ++k) {
    head -= 10.0 * dvec3(std::cos(radians(5.0 * k)), std::sin(radians(5.0 * k)), 0.0);
  }
  expect_near(pose.position[0], head, 1e-9);
}

TEST(Neck, TopAndBaseControlsHaveTheirOwnRegions) {  // R99, R100, R101
  const SpinePose top = straight_pose({{"top_y", 30.0}});
  expect_near(top.position[0], {-126.021701, 0.0, 20.894083}, 1e-5);
  EXPECT_NEAR(degrees(angle_between(top.turn[0], kNoTurn)), 33.854167, 1e-5);
  EXPECT_LE(angle_between(top.turn[12], kNoTurn), 1e-15);  // t = 0 at the base
  const SpinePose base = straight_pose({{"base_y", 30.0}});
  expect_near(base.position[0], {-107.927504, 0.0, 64.997796}, 1e-5);
  EXPECT_NEAR(degrees(angle_between(base.turn[0], kNoTurn)), 43.234040, 1e-5);
  EXPECT_NEAR(measure(base, "gain_z"), 1.625, 1e-12);
  EXPECT_NEAR(measure(base, "gain_base_y"), 1.441135, 1e-6);
  EXPECT_NEAR(measure(base, "gain_top_y"), 650.0 / 576.0, 1e-12);
}

TEST(Neck, RealNeckLiftsItsHead) {  // R102
  EXPECT_NEAR(seed_pose("base_y = 30").position[0].z, 274.124859, 1e-3);
  EXPECT_NEAR(seed_pose("top_y = 30").position[0].z, 245.489207, 1e-3);
}

TEST(Neck, OrderOfTheTurnsIsTheSeeds) {  // R103, R109: other orders miss by 0.5 to 76
  const SpinePose pose = seed_pose("base_z = 24\nbase_y = -20\ntop_y = 35\nroll = 45");
  expect_near(pose.position[0], {30.113509, -374.49003, 212.291005}, 1e-3);
}

TEST(Neck, RollIsAbsoluteLocalAndFadesTowardsTheBase) {  // R104, R105, R106
  const SolveFile file = seed_neck("", "base_y = 25\nbase_z = 10");
  const SolveFile rolled = seed_neck("", "base_y = 25\nbase_z = 10\nroll = 90");
  const SpinePose a = solved(file), b = solved(rolled);
  EXPECT_EQ(a.position, b.position);
  for (int j = 1; j <= 13; ++j) {
    // Vertebra j turns about its own X, which stays: the rest's row 1 carried by the pose.
    const dquat by = glm::conjugate(a.turn[j - 1]) * b.turn[j - 1];
    EXPECT_NEAR(degrees(angle_between(by, kNoTurn)), 90.0 * (1.0 - (j - 1) / 14.0), 1e-6) << j;
  }
  EXPECT_NEAR(turn_between_deg(seed_pose("roll = 90"), file.system->rest(), 12), 12.857143, 1e-5);
  EXPECT_NEAR(turn_between_deg(solved(seed_neck("roll_count = 13", "roll = 45")),
                               seed_pose("roll = 45"), 12),
              45.0 / 14.0 * 2.0 - 45.0 / 13.0, 1e-6);
}

TEST(Neck, RollTakesLocalYToLocalZ) {  // R108
  const SpinePose pose = straight_pose({{"roll", 90.0}});
  expect_near(pose.turn[0] * kAxisY, kAxisZ, 1e-12);
}

TEST(Neck, NormalisedGainsTurnTheHeadByTheControl) {  // R97, A21
  for (const char* control : {"base_z", "base_y", "top_y"}) {
    const SpinePose pose = straight_pose({{control, 65.0}}, {{"gains", "normalised"}});
    EXPECT_NEAR(degrees(angle_between(pose.turn[0], kNoTurn)), 65.0, 1e-9) << control;
  }
  expect_near(straight_pose({{"base_z", 65.0}}, {{"gains", "normalised"}}).position[0],
              {-100.902397, -70.652619, 0.0}, 1e-5);
}

TEST(Neck, LimitsClampAndSay) {  // R93, W18
  const std::vector<double> limits{30, 30, 30, 60};
  const SpinePose pose = straight_pose({{"base_z", 90.0}, {"roll", 10.0}}, {{"limits", limits}});
  EXPECT_EQ(pose.position, straight_pose({{"base_z", 30.0}, {"roll", 10.0}}).position);
  ASSERT_EQ(pose.flags.size(), 1u);
  EXPECT_NE(pose.flags[0].find("base_z"), std::string::npos);
}

TEST(Neck, OtherChannelsAreRefused) {  // R120
  for (const char* pose : {"top_z = 10", "base_x = 5", "roll_y = 3"}) {
    EXPECT_THROW(seed_neck("", pose), RigError) << pose;
  }
}

TEST(Neck, RegionsCanBeGivenForAnyNumberOfVertebrae) {
  RestChain chain;
  for (int i = 0; i < 6; ++i) chain.joint.push_back({0, 1.0 * i, 0});
  const auto neck = build("neck",
                          {{"gains", "normalised"},
                           {"base_weights", std::vector<double>{1, 1, 0, 0, 0}},
                           {"top_weights", std::vector<double>{0, 0, 0, 1, 1}}},
                          chain);
  std::vector<double> control = rest_controls(*neck);
  control[channel(*neck, "base_y")] = radians(40.0);
  const SpinePose pose = neck->solve(control);
  EXPECT_NEAR(turn_between_deg(pose, neck->rest(), 1), 20.0, 1e-9);
  EXPECT_NEAR(turn_between_deg(pose, neck->rest(), 2), 40.0, 1e-9);
  EXPECT_NEAR(turn_between_deg(pose, neck->rest(), 5), 40.0, 1e-9);
  EXPECT_THROW(build("neck", {{"base_weights", std::vector<double>{1, 2}}}, chain), RigError);
  for (const auto& [share, taken] : {std::pair(1000.0, true), {1000.5, false}, {-0.5, false}}) {
    const Options options{{"top_weights", std::vector<double>{0, 0, 0, 1, share}}};
    if (taken)
      EXPECT_NO_THROW(build("neck", options, chain));
    else
      EXPECT_THROW(build("neck", options, chain), RigError) << share;
  }
}

TEST(Neck, OnAnUprightSpineTheSignsAreTheSpecifications) {
  const auto neck = build("neck");  // three driven vertebrae, base first
  EXPECT_EQ(neck->joint_parents()[0], -1);
  for (const Mapping mapping : {Mapping::chest, Mapping::spread}) {
    const auto solve = [&](BodyPose body) {
      return neck->solve(neck->controls_for(body, mapping));
    };
    EXPECT_LT(solve({.extension = 0.8}).position.back().z, -0.3);
    EXPECT_GT(solve({.flexion = 0.8}).position.back().z, 0.3);
    EXPECT_GT(solve({.side = 0.8}).position.back().x, 0.3);
    EXPECT_GT((solve({.twist = 0.8}).turn.back() * kAxisZ).x, 0.6);
    // Gains are divided out: the head turns by what was asked.
    EXPECT_NEAR(angle_between(solve({.extension = 0.8}).turn.back(), kNoTurn), 0.8, 1e-9);
  }
}

TEST(Neck, SumsOfAnglesNeverJump) {
  const auto neck = build("neck", {}, straight_neck());
  for (const char* control : {"base_z", "base_y", "top_y", "roll"}) {
    const auto at = [&](double deg) {
      std::vector<double> c(neck->channels().size(), radians(20.0));
      c[channel(*neck, control)] = radians(deg);
      return c;
    };
    EXPECT_LE(largest_step_deg(*neck, at, -720.0, 720.0, 2.0), 2.0 * 1.625 + 1e-9);
  }
}

TEST(Neck, BadVertebraeAreRefused) {  // R89
  RestChain chain = straight_neck();
  chain.frame[3].rig_from_joint[0] *= 1.1;
  EXPECT_THROW(build("neck", {}, chain), RigError);
  for (const int axis : {0, 1, 2})
    for (const double off : {5e-4, 2e-3}) {  // six digits in a file are taken, a shear is not
      RestChain slanted = straight_neck(), scaled = straight_neck();
      slanted.frame[3].rig_from_joint[axis][(axis + 1) % 3] = off;
      scaled.frame[3].rig_from_joint[axis] *= 1.0 + off;
      if (off < 1e-3) {
        EXPECT_NO_THROW(build("neck", {}, slanted)) << axis;
        EXPECT_NO_THROW(build("neck", {}, scaled)) << axis;
      } else {
        EXPECT_THROW(build("neck", {}, slanted), RigError) << axis;
        EXPECT_THROW(build("neck", {}, scaled), RigError) << axis;
      }
    }
  chain = straight_neck();
  chain.frame[3].rig_from_joint[0] *= -1.0;
  EXPECT_THROW(build("neck", {}, chain), RigError);
  chain = straight_neck();
  chain.frame[3].rig_from_joint[3] = chain.frame[4].rig_from_joint[3];
  EXPECT_THROW(build("neck", {}, chain), RigError);
  chain.frame.resize(1);
  EXPECT_THROW(build("neck", {}, chain), RigError);
}

TEST(Neck, ABadFrameLeavesTheNextOneAlone) {  // R115, R117: nothing is remembered
  const auto neck = build("neck", {}, straight_neck());
  std::vector<double> control = rest_controls(*neck);
  control[0] = 0.3;
  const SpinePose before = neck->solve(control);
  std::vector<double> bad = control;
  bad[1] = std::nan("");
  (void)neck->solve(bad);
  EXPECT_EQ(neck->solve(control).position, before.position);
}

}  // namespace
}  // namespace backbend::solver
