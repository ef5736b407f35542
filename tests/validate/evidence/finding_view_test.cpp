#include "validate/evidence/finding_view.h"

#include <gtest/gtest.h>

namespace backbend::validate {
namespace {

FindingView seen(const char* pose, const char* side = "") {
  Finding finding;
  finding.side = side;
  return view_of(parse_pose(pose), finding);
}

TEST(FindingView, ABendIsSeenInProfileASideBendFromBehindATwistInThreeQuarterView) {
  EXPECT_EQ(seen("extension=60").name, "profile");
  EXPECT_EQ(seen("flexion=90", "front").name, "profile");
  EXPECT_EQ(seen("hip=40").name, "profile");
  EXPECT_EQ(seen("side=-45").name, "back");
  EXPECT_EQ(seen("side=45", "front").name, "front");
  EXPECT_EQ(seen("twist=60").name, "three-quarter");
  EXPECT_EQ(seen("rest").name, "profile");
}

TEST(FindingView, OfSeveralChannelsTheOneCountsThatTurnsMostOfItsRange) {
  EXPECT_EQ(seen("extension=60,side=20,twist=30").name, "profile");
  EXPECT_EQ(seen("extension=30,side=45,twist=30").name, "back");
  EXPECT_EQ(seen("extension=30,side=10,twist=60").name, "three-quarter");
}

TEST(FindingView, WhatIsOnTheRightIsSeenFromTheRight) {
  const render::Facing body{{0, 1, 0}, {0, 0, 1}};
  const FindingView left = seen("extension=60", "left"), right = seen("extension=60", "right");
  EXPECT_EQ(left.camera, right.camera);
  const auto eye = [&](const FindingView& view) {
    return render::close_up(view.camera, {0, 1, 0}, 0.3, view.facing(body), 1.5).eye;
  };
  EXPECT_GT(eye(left).x, 0.5);  // the body's left is +X
  EXPECT_LT(eye(right).x, -0.5);
  EXPECT_GT(eye(seen("twist=60", "front")).z, 0.3);
  EXPECT_LT(eye(seen("twist=60")).z, -0.3);
}

}  // namespace
}  // namespace backbend::validate
