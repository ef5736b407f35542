#include "validate/hunt/hunt_text.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "tests/temporary_folder.h"
#include "validate/sweeps/named_pose.h"

namespace backbend::validate {
namespace {

HuntFind find_at(const std::string& code, const PoseDegrees& from, const PoseDegrees& pose) {
  HuntFind find;
  find.finding.code = code;
  find.finding.value = 63.04;
  find.finding.limit = 25;
  find.finding.unit = "deg";
  find.from = from;
  find.pose = pose;
  return find;
}

Suite suite_of(const std::string& text) {
  const TemporaryFolder folder;
  const auto file = folder / "suite.toml";
  std::ofstream(file) << text;
  return read_suite(file);
}

// No end of line at its end, comments and blanks of its own.
const std::string kSuite =
    "# the night\n[suite]   # ours\ncharacters = [\"human.toml\"]\n\n[[rig]]\n"
    "solver = { system = \"even\" }";

TEST(NamedPoses, OfFindsAreAddedBehindTheSuitesOwnText) {
  Hunt hunt;
  hunt.finds = {find_at("BB011", {}, parse_pose("extension=57.25,side=-44.125")),
                find_at("BB001", parse_pose("twist=59.5"), parse_pose("twist=61.5"))};
  const std::string text = with_poses(kSuite, pose_rows(hunt, suite_of(kSuite)));
  EXPECT_TRUE(text.starts_with(kSuite + "\n"));
  const Suite suite = suite_of(text);
  ASSERT_EQ(suite.poses.size(), 2u);
  EXPECT_TRUE(suite.standard);  // its other sweeps are what they were
  EXPECT_EQ(suite.poses[0].name, "BB011 extension 57, side -44");
  EXPECT_EQ(suite.poses[0].through.back().pose.text(), "extension 57.25, side -44.125");
  EXPECT_EQ(suite.poses[0].through.front().pose.text(), "rest");
  EXPECT_EQ(suite.poses[1].through.front().pose.text(), "twist 59.5");
  EXPECT_NE(text.find("# found by backbend hunt: mesh kink 63.04 deg, limit 25\n"),
            std::string::npos);
}

TEST(NamedPoses, ThatASuiteHasAreNotAddedAgainAndNamesStayApart) {
  Hunt hunt;
  hunt.finds = {find_at("BB011", {}, parse_pose("side=20.1"))};
  const std::string once = with_poses(kSuite, pose_rows(hunt, suite_of(kSuite)));
  EXPECT_TRUE(pose_rows(hunt, suite_of(once)).empty());
  hunt.finds.push_back(find_at("BB011", {}, parse_pose("side=20.2")));
  const auto more = pose_rows(hunt, suite_of(once));
  ASSERT_EQ(more.size(), 1u);
  EXPECT_EQ(more.front().name, "BB011 side 20 2");
  EXPECT_EQ(suite_of(with_poses(once, more)).poses.size(), 2u);
}

TEST(NamedPoses, KeepAFilesOwnEndsOfLines) {
  const std::string text = with_poses("[suite]\r\n", {{"a", "side=1", "", "why"}});
  EXPECT_EQ(text, "[suite]\r\n\r\n[[pose]]  # why\r\nname = \"a\"\r\nat = \"side=1\"\r\n");
}

TEST(NamedPose, IsTheEndOfAPathFromRest) {
  const Sweep sweep = named_pose("hero", {}, parse_pose("extension=60,side=45,twist=-30"));
  EXPECT_EQ(sweep.pose_count(), 13u);
  EXPECT_EQ(sweep.pose_at(sweep.control_at(12)).text(), "extension 60, side 45, twist -30");
  EXPECT_EQ(sweep.pose_at(sweep.control_at(0)).text(), "rest");
  EXPECT_THROW(named_pose("none", {}, {}), solver::RigError);
}

TEST(NamedPose, NeverBendsBothWaysOnItsPath) {
  const Sweep sweep =
      named_pose("across", parse_pose("extension=1,side=10"), parse_pose("flexion=1,side=12"));
  for (std::size_t i = 0; i < sweep.pose_count(); ++i) {
    const PoseDegrees pose = sweep.pose_at(sweep.control_at(i));
    EXPECT_TRUE(pose.extension <= 1e-12 || pose.flexion <= 1e-12) << pose.text();
  }
  EXPECT_EQ(sweep.pose_at(sweep.to_deg).text(), "flexion 1, side 12");
}

TEST(PoseWords, AreReadBackAsTheSamePose) {
  const PoseDegrees pose = in_file_digits(parse_pose("extension=100.8696751234,twist=-0.0000004"));
  EXPECT_EQ(pose_words(pose), "extension=100.869675");
  EXPECT_EQ(parse_pose(pose_words(pose)).extension, pose.extension);
  EXPECT_EQ(pose_words({}), "rest");
}

}  // namespace
}  // namespace backbend::validate
