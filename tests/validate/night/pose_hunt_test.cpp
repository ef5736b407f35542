#include "validate/night/pose_hunt.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "validate/sweeps/named_pose.h"

namespace backbend::validate {
namespace {

constexpr const char* kPath = "hunt even BB011";

RigRecord hunted_rig() {
  RigRecord rig;
  rig.plan.name = "even";
  rig.hunt.worst = {{"BB011", "deg", "extension 40, side 30", 60.0, 25.0, true, 1},
                    {"BB030", "ratio", "side 45", 0.7, 0.75, true, -1}};
  return rig;
}

Finding finding(const std::string& code, const std::string& sweep, double value, double limit,
                bool inside = true) {
  Finding out;
  out.code = code;
  out.at.sweep = sweep == kPath ? 1 : 0;
  out.sweep = sweep;
  out.value = value;
  out.limit = limit;
  out.inside_envelope = inside;
  return out;
}

std::vector<std::string> left_of(std::vector<Finding> findings) {
  drop_repeats(hunted_rig(), findings);
  std::vector<std::string> out;
  for (const Finding& each : findings) out.push_back(each.code + " " + each.sweep);
  return out;
}

TEST(HuntName, IsTheSameEveryNightAndCountsASecondFlip) {
  EXPECT_EQ(hunt_name(hunted_rig(), "BB011", 1), kPath);
  EXPECT_EQ(hunt_name(hunted_rig(), "BB001", 2), "hunt even BB001 2");
}

/// A rig whose hunt saw a near flip and a jump, each on a path that was measured: gains of the
/// first path's poses, jumps of the second's half way.
RigRecord rig_with_flips(const std::vector<double>& gains, const std::vector<double>& jumps_deg) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  RigRecord rig;
  rig.hunt.worst = {{"BB002", "deg/deg", "side 40", nan, nan, true, 0},
                    {"BB001", "deg", "side 40", nan, nan, true, 1}};
  rig.sweeps.resize(2);
  rig.sweeps[0].sweep = named_pose("near", {}, {.side = 40.0});
  rig.sweeps[1].sweep = named_pose("jump", {}, {.side = 40.0});
  for (const double gain : gains) {
    PoseRecord& pose = rig.sweeps[0].poses.emplace_back();
    pose.body.side = 10.0 * static_cast<double>(rig.sweeps[0].poses.size());
    pose.at(MetricId::gain).value = gain;
  }
  for (const double size : jumps_deg) {
    Jump& jump = rig.sweeps[1].flips.jumps.emplace_back();
    jump.t = 0.5;
    jump.joints.emplace_back().size_deg = size;
  }
  return rig;
}

TEST(FlipsOfAHunt, HaveTheValueAndThePoseThatTheirPathsShow) {
  RigRecord rig = rig_with_flips({1.0, 12.0, std::nan(""), 3.0}, {90.0});
  confirm_flips(rig, LimitSet());
  ASSERT_EQ(rig.hunt.worst.size(), 2u);
  EXPECT_EQ(rig.hunt.worst[0].code, "BB001");
  EXPECT_EQ(rig.hunt.worst[0].value, 90.0);
  EXPECT_EQ(rig.hunt.worst[0].pose, "side 20");
  EXPECT_EQ(rig.hunt.worst[1].value, 12.0);
  EXPECT_EQ(rig.hunt.worst[1].pose, "side 20");
  EXPECT_EQ(rig.hunt.worst[1].limit, 8.0);
  EXPECT_EQ(rig.sweeps.size(), 2u);
}

TEST(FlipsOfAHunt, ThatNoMeasureConfirmsAreNotFoundAndTheirPathsGo) {
  RigRecord rig = rig_with_flips({1.0, 1.0}, {});
  confirm_flips(rig, LimitSet());
  EXPECT_TRUE(rig.hunt.worst.empty());
  EXPECT_TRUE(rig.sweeps.empty());
}

TEST(FlipsOfAHunt, AreStillOnTheirPathsWhereOneBeforeThemGoes) {
  RigRecord rig = rig_with_flips({1.0}, {90.0});  // the first path shows no flip
  confirm_flips(rig, LimitSet());
  ASSERT_EQ(rig.hunt.worst.size(), 1u);
  ASSERT_EQ(rig.sweeps.size(), 1u);
  EXPECT_EQ(rig.hunt.worst[0].sweep, 0);
  EXPECT_EQ(rig.sweeps[0].sweep.name, "jump");
}

TEST(FlipsOfAHunt, LeaveAPathThatAnotherFindIsOn) {
  RigRecord rig = rig_with_flips({1.0}, {90.0});
  rig.hunt.worst.push_back({"BB011", "deg", "side 40", 60.0, 25.0, true, 0});
  confirm_flips(rig, LimitSet());
  ASSERT_EQ(rig.hunt.worst.size(), 2u);
  EXPECT_EQ(rig.hunt.worst[1].code, "BB011");
  EXPECT_EQ(rig.sweeps.size(), 2u);
}

TEST(PathsOfAHunt, KeepWhatTheyWereMadeFor) {
  const auto left =
      left_of({finding("BB011", kPath, 60, 25), finding("BB011", "extension", 59, 25)});
  EXPECT_EQ(left, (std::vector<std::string>{"BB011 hunt even BB011", "BB011 extension"}));
}

TEST(PathsOfAHunt, DoNotRepeatWhatASweepShowsNearlyAsBadly) {
  const auto left =
      left_of({finding("BB036", kPath, 16.4, 15), finding("BB036", "extension", 15.5, 15)});
  EXPECT_EQ(left, (std::vector<std::string>{"BB036 extension"}));
}

TEST(PathsOfAHunt, KeepWhatIsWorseThereOrShownNowhereElse) {
  // A tenth more than elsewhere; only there; and elsewhere outside the envelope alone.
  const auto left = left_of({finding("BB036", kPath, 18, 15), finding("BB036", "extension", 16, 15),
                             finding("BB033", kPath, 1.1, 1), finding("BB012", kPath, 2.1, 2),
                             finding("BB012", "extension", 9, 2, false)});
  EXPECT_EQ(left.size(), 5u);
}

}  // namespace
}  // namespace backbend::validate
