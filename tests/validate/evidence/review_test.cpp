#include "validate/evidence/review.h"

#include <gtest/gtest.h>

namespace backbend::validate {
namespace {

TEST(Review, ShowsEveryPoseOnceAndStandsStillAtTheWorst) {
  const auto frames = held_at(5, 2, 3);
  ASSERT_EQ(frames.size(), 8u);
  const std::vector<std::size_t> poses{0, 1, 2, 2, 2, 2, 3, 4};
  for (std::size_t i = 0; i < poses.size(); ++i) {
    EXPECT_EQ(frames[i].pose, poses[i]) << i;
    EXPECT_EQ(frames[i].held, i >= 3 && i <= 5) << i;
  }
  EXPECT_EQ(held_at(1, 0, 2).size(), 3u);
}

TEST(Review, HoldsThePoseNearestToTheFinding) {
  const std::vector<double> angles{0, 2, 4, 6};
  EXPECT_EQ(nearest_pose(angles, 3.9), 2u);
  EXPECT_EQ(nearest_pose(angles, 3.0), 2u);  // past a flip halfway
  EXPECT_EQ(nearest_pose(angles, -5), 0u);
  EXPECT_EQ(nearest_pose(angles, 500), 3u);
}

TEST(Review, TellsWhichAngleEachFrameShows) {
  EXPECT_EQ(review_csv(held_at(2, 1, 1), {0, 2.5}),
            "frame,seconds,control_deg,held\r\n"
            "1001,0.0000,0,0\r\n1002,0.0417,2.5,0\r\n1003,0.0833,2.5,1\r\n");
}

}  // namespace
}  // namespace backbend::validate
