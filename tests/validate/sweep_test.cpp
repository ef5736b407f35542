#include "validate/sweeps/sweep.h"

#include <gtest/gtest.h>

namespace backbend::validate {
namespace {

TEST(ParsePose, ReadsChannelsInAnyOrder) {
  const PoseDegrees pose = parse_pose("side=10, extension=90");
  EXPECT_EQ(pose.extension, 90.0);
  EXPECT_EQ(pose.side, 10.0);
  EXPECT_EQ(pose.text(), "extension 90, side 10");
  EXPECT_EQ(parse_pose("").text(), "rest");
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

TEST(Sweep, StandardOnesReachWhatTheSpecificationAsks) {
  const std::vector<Sweep> sweeps = standard_sweeps();
  const auto reaches = [&](const std::string& name, double from, double to) {
    for (const Sweep& sweep : sweeps) {
      if (sweep.name == name)
        return sweep.from_deg == from && sweep.control_at(sweep.pose_count() - 1) == to;
    }
    return false;
  };
  EXPECT_TRUE(reaches("extension", 0, 120));
  EXPECT_TRUE(reaches("flexion", 0, 90));
  EXPECT_TRUE(reaches("side", -45, 45));
  EXPECT_TRUE(reaches("twist", -90, 90));
}

TEST(Envelope, HoldsItsBorderAndNothingBeyond) {
  const Envelope human = *find_envelope("human");
  EXPECT_TRUE(human.contains(parse_pose("extension=60")));
  EXPECT_FALSE(human.contains(parse_pose("extension=60.1")));
  EXPECT_TRUE(human.contains(parse_pose("side=-45")));
  EXPECT_FALSE(human.contains(parse_pose("extension=10,twist=61")));
}

TEST(Envelope, OfAComparisonIsTheWholeSweep) {
  EXPECT_TRUE(find_envelope("sweep")->contains(parse_pose("extension=180,twist=720")));
  EXPECT_FALSE(find_envelope("horse").has_value());
}

TEST(NumberText, IsShortAndNeverNegativeZero) {
  EXPECT_EQ(number_text(114.3), "114.3");
  EXPECT_EQ(number_text(180.0), "180");
  EXPECT_EQ(number_text(-0.0001), "0");
  EXPECT_EQ(number_text(100.0, 0), "100");
  EXPECT_EQ(number_text(std::nan("")), "not measured");
  EXPECT_EQ(number_text(1e300).size(), 301u);
}

TEST(NearestName, SuggestsOnlyWhatIsNear) {
  EXPECT_EQ(nearest_name("isnr", {"curve", "isner"}), "isner");
  EXPECT_EQ(nearest_name("cat", {"matrix_blend", "three_bone"}), std::nullopt);
}

}  // namespace
}  // namespace backbend::validate
