#include "validate/sweeps/sweep.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace backbend::validate {
namespace {

TEST(ParsePose, ReadsChannelsInAnyOrder) {
  const PoseDegrees pose = parse_pose("side=10, extension=90");
  EXPECT_EQ(pose.extension, 90.0);
  EXPECT_EQ(pose.side, 10.0);
  EXPECT_EQ(pose.text(), "extension 90, side 10");
  EXPECT_EQ(parse_pose("").text(), "rest");
  EXPECT_EQ(parse_pose(" rest ").text(), "rest");  // as poses are written
}

TEST(ParsePose, ReadsATippedHipAndAStretchInPerCent) {
  const PoseDegrees pose = parse_pose("hip=30,stretch=-20");
  EXPECT_EQ(pose.text(), "hip 30, stretch -20");
  EXPECT_NEAR(pose.radians().hip, 0.5235987755982988, 1e-15);
  EXPECT_NEAR(pose.radians().stretch, 0.8, 1e-15);
  EXPECT_EQ(parse_pose("").radians().stretch, 1.0);
  EXPECT_THROW(parse_pose("stretch=-95"), solver::RigError);
  EXPECT_NO_THROW(parse_pose("stretch=-94"));
}

TEST(ParsePose, NamesTheNearestChannelOfAMistypedOne) {
  try {
    parse_pose("extention=90");
    FAIL() << "a channel that does not exist was accepted";
  } catch (const solver::RigError& error) {
    EXPECT_NE(std::string(error.what()).find("did you mean 'extension'"), std::string::npos)
        << error.what();
  }
}

TEST(ParsePose, RefusesWhatIsNoFiniteNumber) {
  for (const char* text :
       {"twist=", "twist=abc", "twist=nan", "twist=inf", "twist=1e999", "twist", "twist=1,5"}) {
    EXPECT_THROW(parse_pose(text), solver::RigError) << text;
  }
}

TEST(Sweep, EndsExactlyWhereItSays) {
  const Sweep sweep = channel_sweep("extension", 0, 180, 2);
  ASSERT_EQ(sweep.pose_count(), 91u);
  EXPECT_EQ(sweep.control_at(0), 0.0);
  EXPECT_EQ(sweep.control_at(90), 180.0);
  EXPECT_EQ(sweep.pose_at(90.0).extension, 90.0);
  EXPECT_EQ(sweep.pose_at(90.0).side, 0.0);
}

TEST(Sweep, WalksDownwardsToo) {
  const Sweep sweep = channel_sweep("twist", 90, -90, 30);
  ASSERT_EQ(sweep.pose_count(), 7u);
  EXPECT_EQ(sweep.control_at(6), -90.0);
}

TEST(Sweep, AGridCoversSideAndTwistAtEveryExtension) {
  const std::vector<Sweep> grid = grid_sweeps();
  ASSERT_EQ(grid.size(), 25u);
  EXPECT_EQ(grid.front().pose_at(0).text(), "side -60, twist -90");
  EXPECT_EQ(grid.back().pose_at(150).text(), "extension 150, side 60, twist 90");
}

TEST(Sweep, APathGoesStraightFromPoseToPose) {
  const std::vector<PoseDegrees> poses = {{}, {30, 0, 10, 0}, {30, 0, 10, 0}, {30, 0, 10, -60}};
  const Sweep path = path_sweep("dance", poses, 10);
  ASSERT_EQ(path.through.size(), 3u);  // the repeated pose is no leg
  EXPECT_EQ(path.to_deg, 90.0);        // 30 of extension, then 60 of twist
  EXPECT_EQ(path.pose_at(15).text(), "extension 15, side 5");
  EXPECT_EQ(path.pose_at(30).text(), "extension 30, side 10");
  EXPECT_EQ(path.pose_at(60).text(), "extension 30, side 10, twist -30");
  EXPECT_EQ(path.pose_at(91).text(), "extension 30, side 10, twist -61");
  EXPECT_THROW(path_sweep("still", std::vector<PoseDegrees>(3), 1), solver::RigError);
}

TEST(Sweep, AWalkIsOneUnbrokenPathThatNeverBendsBothWays) {
  const Sweep walk = random_walk(7, 40, 1);
  PoseDegrees before = walk.pose_at(0);
  for (std::size_t i = 1; i < walk.pose_count(); ++i) {
    const PoseDegrees pose = walk.pose_at(walk.control_at(i));
    double step = 0.0;
    for (const std::string_view channel : kChannels)
      step = std::max(step, std::abs(*pose.find(channel) - *before.find(channel)));
    ASSERT_LE(step, 1.0 + 1e-9) << pose.text();
    ASSERT_TRUE(pose.extension < 1e-9 || pose.flexion < 1e-9) << pose.text();
    before = pose;
  }
  EXPECT_EQ(random_walk(7, 40, 1).through.back().pose.text(), walk.through.back().pose.text());
  EXPECT_NE(random_walk(8, 40, 1).through.back().pose.text(), walk.through.back().pose.text());
  // Pinned: the same walk on every machine and compiler.
  EXPECT_EQ(random_walk(1, 12, 8).through[1].pose.text(), "flexion 62, side -44, twist -12");
}

TEST(Sweep, StressSetsHipAgainstChestAndCompressesAndStretches) {
  const auto ends = [](const std::string& name) {
    for (const Sweep& sweep : stress_sweeps())
      if (sweep.name == name)
        return sweep.pose_at(sweep.from_deg).text() + " to " +
               sweep.pose_at(sweep.control_at(sweep.pose_count() - 1)).text();
    return std::string("none");
  };
  EXPECT_EQ(ends("hip_chest"), "hip -60 to hip 60");
  EXPECT_EQ(ends("compress"), "rest to stretch -40");
  EXPECT_EQ(ends("stretch"), "rest to stretch 40");
}

TEST(Sweep, WhatARigHasNoControlForIsNamed) {
  const solver::RestChain chain{{{0, 0, 0}, {0, 1, 0}, {0, 2, 0}, {0, 3, 0}}, {1, 0, 0}};
  const auto curve = solver::build_system({"curve", {}}, chain);
  EXPECT_EQ(why_not_taken(*curve, parse_pose("extension=90")), "");
  EXPECT_EQ(why_not_taken(*curve, parse_pose("stretch=5")),
            "stretch: its controls turn and do not move");
  EXPECT_EQ(why_not_taken(*curve, parse_pose("stretch=5,hip=1")).rfind("hip: ", 0), 0u);
  const auto isner = solver::build_system({"isner", {}}, chain);
  EXPECT_EQ(why_not_taken(*isner, parse_pose("stretch=5,hip=1")), "");
}

TEST(NumberText, IsShortAndNeverNegativeZero) {
  EXPECT_EQ(number_text(114.3), "114.3");
  EXPECT_EQ(number_text(180.0), "180");
  EXPECT_EQ(number_text(-0.0001), "0");
  EXPECT_EQ(number_text(100.0, 0), "100");
  EXPECT_EQ(number_text(std::nan("")), "not measured");
  EXPECT_EQ(number_text(1e300).size(), 301u);
}

}  // namespace
}  // namespace backbend::validate
