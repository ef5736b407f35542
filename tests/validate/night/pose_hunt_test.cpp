#include "validate/night/pose_hunt.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace backbend::validate {
namespace {

constexpr const char* kPath = "hunt even BB011";

RigRecord hunted_rig() {
  RigRecord rig;
  rig.plan.name = "even";
  rig.hunt.worst = {{"BB011", "deg", "extension 40, side 30", 60.0, 25.0, true, kPath},
                    {"BB030", "ratio", "side 45", 0.7, 0.75, true, ""}};
  return rig;
}

Finding finding(const std::string& code, const std::string& sweep, double value, double limit,
                bool inside = true) {
  Finding out;
  out.code = code;
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
