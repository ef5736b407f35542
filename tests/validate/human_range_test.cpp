#include "validate/metrics/human_range.h"

#include <gtest/gtest.h>

namespace backbend::validate {
namespace {

TEST(HumanRange, OfTheWholeSpineIsTheSumOfItsLevels) {
  const MotionRange whole = human_range(0.0, 1.0);
  EXPECT_NEAR(whole.flexion, 38.7 + 11 * 3.5 + 7.0, 1e-9);
  EXPECT_NEAR(whole.extension, 25.9 + 11 * 3.5 + 7.0, 1e-9);
  EXPECT_NEAR(whole.axial, 11.1 + 3 * 3.75 + 9 * 5.5, 1e-9);
  const MotionRange low = human_range(0.0, 0.2), mid = human_range(0.2, 0.7),
                    high = human_range(0.7, 1.0);
  EXPECT_NEAR(low.lateral + mid.lateral + high.lateral, whole.lateral, 1e-9);
}

TEST(HumanRange, OfTheLoinsIsLittleTwistAndMuchNod) {
  const MotionRange loins = human_range(0.0, 0.38), chest = human_range(0.38, 1.0);
  EXPECT_LT(loins.axial, 0.2 * chest.axial);
  EXPECT_GT(loins.flexion, 0.8 * chest.flexion);
}

solver::SpinePose bent(const glm::dvec3& per_joint) {
  solver::SpinePose pose;
  for (int i = 0; i <= 10; ++i) {
    pose.position.push_back({0.0, 0.1 * i, 0.0});
    pose.turn.push_back(rotation(per_joint * static_cast<double>(std::min(i, 9))));
  }
  return pose;
}
std::vector<double> tenths() {
  std::vector<double> out;
  for (int i = 0; i <= 10; ++i) out.push_back(0.1 * i);
  return out;
}

TEST(HumanRangeUse, NamesTheDirectionAndTheJointThatGoesFurthest) {
  const glm::dvec3 left(1, 0, 0);
  const solver::SpinePose rest = bent(glm::dvec3(0));
  EXPECT_EQ(human_range_use(rest, rest, tenths(), left).ratio, 0.0);
  // +Y up, +Z forward: about +X the top goes forward.
  const RangeUse forward = human_range_use(bent({0.1, 0, 0}), rest, tenths(), left);
  EXPECT_EQ(forward.direction, "flexion");
  const RangeUse back = human_range_use(bent({-0.1, 0, 0}), rest, tenths(), left);
  EXPECT_EQ(back.direction, "extension");
  EXPECT_GT(back.ratio, 0.0);
  const RangeUse twist = human_range_use(bent({0, 0.1, 0}), rest, tenths(), left);
  EXPECT_EQ(twist.direction, "axial");
  EXPECT_LE(twist.joint, 4);  // the loins hardly twist
  EXPECT_EQ(human_range_use(bent({0, 0, 0.1}), rest, tenths(), left).direction, "lateral");
}

TEST(HumanRangeUse, IsTheAngleOverTheRangeOfTheStretch) {
  const solver::SpinePose rest = bent(glm::dvec3(0));
  solver::SpinePose pose = rest;
  for (std::size_t i = 5; i < pose.turn.size(); ++i)
    pose.turn[i] = rotation({radians_from(-20.0), 0, 0});
  const RangeUse use = human_range_use(pose, rest, tenths(), {1, 0, 0});
  EXPECT_EQ(use.joint, 5);
  EXPECT_NEAR(use.ratio, 20.0 / human_range(0.45, 0.55).extension, 1e-9);
}

}  // namespace
}  // namespace backbend::validate
