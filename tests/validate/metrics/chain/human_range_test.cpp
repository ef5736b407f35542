#include "validate/metrics/chain/human_range.h"

#include <gtest/gtest.h>

#include <utility>

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

// The published levels (docs and source beside human_range), as a plain sum over a stretch.
TEST(HumanRange, OfAnyStretchIsThatOfTheLevelsInIt) {
  const MotionRange level[] = {
      {10.0, 7.8, 5.5, 1.4}, {8.9, 5.8, 5.7, 2.2},   {7.5, 3.7, 5.7, 2.6},   {6.5, 4.3, 7.0, 2.6},
      {5.8, 4.3, 4.9, 2.3},  {3.5, 3.5, 4.25, 3.75}, {3.5, 3.5, 4.25, 3.75}, {3.5, 3.5, 4.25, 3.75},
      {3.5, 3.5, 4.25, 5.5}, {3.5, 3.5, 4.25, 5.5},  {3.5, 3.5, 4.25, 5.5},  {3.5, 3.5, 5.5, 5.5},
      {3.5, 3.5, 5.5, 5.5},  {3.5, 3.5, 5.5, 5.5},   {3.5, 3.5, 5.5, 5.5},   {3.5, 3.5, 5.5, 5.5},
      {7.0, 7.0, 5.5, 5.5}};
  constexpr int kFine = 17000;
  for (const auto& [from, to] : {std::pair(0.0, 0.076), std::pair(0.05, 0.31), std::pair(0.35, 0.5),
                                 std::pair(0.6, 1.0), std::pair(0.2, 0.9)}) {
    MotionRange sum{0, 0, 0, 0};
    for (int i = 0; i < kFine; ++i) {  // 5 levels up to 0.38, twelve above
      const double s = (i + 0.5) / kFine;
      if (s < from || s > to) continue;
      const int at = s < 0.38 ? static_cast<int>(s / 0.38 * 5.0)
                              : 5 + static_cast<int>((s - 0.38) / 0.62 * 12.0);
      const double share = (s < 0.38 ? 5.0 / 0.38 : 12.0 / 0.62) / kFine;
      sum.flexion += share * level[at].flexion;
      sum.extension += share * level[at].extension;
      sum.lateral += share * level[at].lateral;
      sum.axial += share * level[at].axial;
    }
    const MotionRange range = human_range(from, to);
    EXPECT_NEAR(range.flexion, sum.flexion, 0.01) << from;
    EXPECT_NEAR(range.extension, sum.extension, 0.01) << from;
    EXPECT_NEAR(range.lateral, sum.lateral, 0.01) << from;
    EXPECT_NEAR(range.axial, sum.axial, 0.01) << from;
  }
}

TEST(HumanRangeUse, MeasuresEachDirectionInTheBodysOwnAxes) {
  // The same chain lying on its side and somewhere else: up is +Z, left is +Y, forward is -X.
  const glm::dquat lie = glm::quat_cast(glm::dmat3({0, 1, 0}, {0, 0, 1}, {1, 0, 0}));
  for (const glm::dquat& world : {glm::dquat(1, 0, 0, 0), lie}) {
    const glm::dvec3 left = world * glm::dvec3(1, 0, 0), up = world * glm::dvec3(0, 1, 0);
    const glm::dvec3 forward = world * glm::dvec3(0, 0, 1);
    solver::SpinePose rest = bent(glm::dvec3(0));
    for (glm::dvec3& p : rest.position) p = world * p + glm::dvec3(3, -1, 2);
    const MotionRange range = human_range(0.45, 0.55);
    const struct {
      glm::dvec3 axis;
      double deg, range;
      std::string_view direction;
    } cases[] = {{left, 12, range.flexion, "flexion"},    {left, -12, range.extension, "extension"},
                 {up, 12, range.axial, "axial"},          {up, -12, range.axial, "axial"},
                 {forward, 12, range.lateral, "lateral"}, {forward, -12, range.lateral, "lateral"}};
    for (const auto& c : cases) {
      solver::SpinePose pose = rest;
      // What lies below turns along, and counts for nothing.
      const glm::dquat below = rotation(glm::dvec3(0.3, -0.8, 0.5));
      for (std::size_t i = 0; i < pose.turn.size(); ++i)
        pose.turn[i] =
            below * (i < 5 ? glm::dquat(1, 0, 0, 0) : rotation(radians_from(c.deg) * c.axis));
      // What is said to be left may lean: only its part across the spine counts.
      const RangeUse use = human_range_use(pose, rest, tenths(), glm::normalize(left + 0.35 * up));
      EXPECT_EQ(use.direction, c.direction);
      EXPECT_EQ(use.joint, 5);
      EXPECT_NEAR(use.ratio, 12.0 / c.range, 1e-9) << c.direction;
    }
  }
}

TEST(HumanRangeUse, PassesOverBonesWithoutLengthAndTheTip) {
  solver::SpinePose rest = bent(glm::dvec3(0));
  std::vector<double> at = tenths();
  rest.position[6] = rest.position[5];
  at[6] = at[5];
  solver::SpinePose pose = rest;
  for (std::size_t i = 5; i < pose.turn.size(); ++i) pose.turn[i] = rotation({0.2, 0, 0});
  // The joint below the bone without length has the half bone below it and nothing above.
  const RangeUse use = human_range_use(pose, rest, at, {1, 0, 0});
  EXPECT_EQ(use.joint, 5);
  EXPECT_NEAR(use.ratio, degrees(0.2) / human_range(0.45, 0.5).flexion, 1e-9);
  EXPECT_EQ(human_range_use(rest, rest, at, {1, 0, 0}).joint, RangeUse{}.joint);
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
