// The curvature comb of the torso's mid lines: equal teeth in an even bend, a jump at a crease.
#include "validate/metrics/surface/comb_jump.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/gtc/quaternion.hpp>
#include <glm/trigonometric.hpp>

namespace backbend::validate {
namespace {

constexpr std::size_t kSlices = 40;
constexpr int kWindow = 5;

/// Slices whose every ring has all its lines on the surface.
SpineSlices whole_slices() {
  SpineSlices out;
  out.slice.resize(kSlices);
  for (Slice& slice : out.slice) slice.line.resize(kLineCount);
  return out;
}

/// The mid lines as `at` has them, by the slice's number.
template <class Curve>
SlicePose lines_along(const Curve& at) {
  SlicePose out;
  out.line.resize(kSlices * kLineCount);
  for (std::size_t s = 0; s < kSlices; ++s)
    for (int k = 0; k < kLineCount; ++k)
      out.line[s * kLineCount + static_cast<std::size_t>(k)] =
          at(static_cast<double>(s)) + glm::dvec3(0.0, 0.0, k < kLineCount / 2 ? 1.0 : -1.0);
  return out;
}

glm::dvec3 straight(double s) { return {0.0, s, 0.0}; }

/// Turned by `degrees` about X at slice 20 and straight before and after.
glm::dvec3 creased(double s, double degrees) {
  const double after = std::max(0.0, s - 20.0), angle = glm::radians(degrees);
  return {0.0, std::min(s, 20.0) + after * std::cos(angle), after * std::sin(angle)};
}

TEST(CombJump, OfAnEvenBendIsNone) {
  const SlicePose arc = lines_along([](double s) {
    const double angle = glm::radians(3.0 * s);
    return glm::dvec3(0.0, 20.0 * std::sin(angle), 20.0 * (1.0 - std::cos(angle)));
  });
  EXPECT_NEAR(comb_jump(whole_slices(), lines_along(straight), arc, kWindow).angle_deg, 0.0, 1e-9);
}

TEST(CombJump, OfACreaseIsItsAngleAndThere) {
  const SpineSlices slices = whole_slices();
  const SlicePose rest = lines_along(straight);
  const SlicePose pose = lines_along([](double s) { return creased(s, 30.0); });
  const CombJump found = comb_jump(slices, rest, pose, kWindow);
  EXPECT_NEAR(found.angle_deg, 30.0, 1e-9);
  EXPECT_NEAR(found.slice, 20, kWindow);

  // Turned, moved and of another size it is the same.
  const glm::dquat turn = glm::angleAxis(1.1, glm::normalize(glm::dvec3(1.0, -2.0, 0.5)));
  SlicePose moved = pose;
  for (glm::dvec3& point : moved.line) point = turn * (0.01 * point) + glm::dvec3(3.0, 1.0, -2.0);
  EXPECT_NEAR(comb_jump(slices, rest, moved, kWindow).angle_deg, 30.0, 1e-9);
}

TEST(CombJump, LeavesOutWhatTheRestHas) {
  const SlicePose rest = lines_along([](double s) { return creased(s, 20.0); });
  const SlicePose pose = lines_along([](double s) { return creased(s, 50.0); });
  EXPECT_NEAR(comb_jump(whole_slices(), rest, rest, kWindow).angle_deg, 0.0, 1e-12);
  EXPECT_NEAR(comb_jump(whole_slices(), rest, pose, kWindow).angle_deg, 30.0, 1e-9);
}

TEST(CombJump, OfALineThatIsInterruptedIsNotMeasured) {
  SpineSlices slices = whole_slices();
  const SlicePose rest = lines_along(straight);
  const SlicePose pose = lines_along([](double s) { return creased(s, 30.0); });
  for (std::size_t s = 0; s < kSlices; s += 2) slices.slice[s].line.clear();
  EXPECT_TRUE(std::isnan(comb_jump(slices, rest, pose, 1).angle_deg));
  for (Slice& slice : slices.slice) slice.spine_share = 0.1;
  EXPECT_TRUE(std::isnan(comb_jump(slices, rest, pose, kWindow).angle_deg));
}

}  // namespace
}  // namespace backbend::validate
