// Motion of other programs laid onto a character.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "validate/clips/clip_measure.h"
#include "validate/metrics/surface/rigid_fit.h"

namespace backbend::validate {
namespace {

constexpr double kTolerance = 1e-9;  // a few hundred roundings of numbers near 1

glm::dquat random_turn(std::mt19937& rng) {
  const auto unit = [&] { return static_cast<double>(rng()) / 4294967295.0 - 0.5; };
  return glm::normalize(glm::dquat(unit(), unit(), unit(), unit()));
}

TEST(RigidFit, FindsTheMotionThatMovedThePoints) {
  std::mt19937 rng(5);
  const std::vector<glm::dvec3> rest = {{0, 0, 0}, {1, 0, 0}, {0, 2, 0}, {0, 0, 0.5}, {1, 1, 1}};
  const std::vector<double> weight = {1.0, 0.5, 0.25, 1.0, 0.1};
  for (int i = 0; i < 200; ++i) {
    const glm::dquat turn = random_turn(rng);
    const glm::dvec3 way(0.1 * i, -2.0, 1.0);
    std::vector<glm::dvec3> posed;
    for (const glm::dvec3& p : rest) posed.push_back(turn * p + way);
    const solver::RigidMotion found = fit_rigid(rest, posed, weight);
    EXPECT_LT(angle_between(found.turn, turn), 1e-7) << i;
    EXPECT_LT(glm::distance(found.apply(rest[4]), posed[4]), 1e-7) << i;
  }
}

TEST(RigidFit, HalfATurnIsNoSpecialCase) {
  const std::vector<glm::dvec3> rest = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 0}};
  const glm::dquat half(0, 0, 1, 0);
  std::vector<glm::dvec3> posed;
  for (const glm::dvec3& p : rest) posed.push_back(half * p);
  EXPECT_LT(angle_between(fit_rigid(rest, posed, std::vector<double>(4, 1.0)).turn, half), 1e-7);
}

TEST(NearestRotation, IsWhatIsLeftWithoutStretchAndShear) {
  std::mt19937 rng(6);
  for (int i = 0; i < 200; ++i) {
    const glm::dquat turn = random_turn(rng);
    const glm::dmat3 stretch(2.0, 0.3, 0.1, 0.3, 1.0, 0.2, 0.1, 0.2, 0.7);  // symmetric, positive
    EXPECT_LT(angle_between(nearest_rotation(glm::mat3_cast(turn) * stretch), turn), 1e-7) << i;
  }
}

TEST(NearestRotation, AMirrorAndACollapseHaveNone) {
  EXPECT_FALSE(is_finite(nearest_rotation(glm::dmat3(-1, 0, 0, 0, 1, 0, 0, 0, 1))));
  EXPECT_FALSE(is_finite(nearest_rotation(glm::dmat3(0.0))));
}

TEST(PathPops, SteadyAndEasedMotionHasNone) {
  std::vector<glm::dvec3> path;
  std::vector<double> time;
  for (int f = 0; f < 40; ++f) {
    time.push_back(f / 24.0);
    path.emplace_back(std::sin(0.1 * f), 0.02 * f, 0.0);
  }
  for (const double pop : path_pops(path, time)) EXPECT_LT(pop, kTolerance);
}

TEST(PathPops, AStepIsFoundWhereItEndsByItsSize) {
  std::vector<glm::dvec3> path;
  std::vector<double> time;
  for (int f = 0; f < 40; ++f) {
    time.push_back(f / 24.0);
    path.emplace_back(0.01 * f + (f >= 17 ? 0.3 : 0.0), 0.0, 0.0);
  }
  const std::vector<double> pops = path_pops(path, time);
  EXPECT_NEAR(pops[17], 0.3, kTolerance);
  EXPECT_EQ(std::max_element(pops.begin(), pops.end()) - pops.begin(), 17);
}

TEST(PathPops, AThrustHasNoneAndAPopOfOneFrameIsAsLargeAsItIs) {
  std::vector<double> time;
  for (int f = 0; f < 40; ++f) time.push_back(f / 24.0);
  std::vector<glm::dvec3> thrust(40, glm::dvec3(0.0)), pop(40, glm::dvec3(0.0));
  // Out in four frames, back in eight.
  const double out[] = {0.0, 0.1, 0.45, 0.85, 1.0, 0.98, 0.9, 0.75, 0.55, 0.35, 0.18, 0.06};
  for (int f = 0; f < 12; ++f) thrust[static_cast<std::size_t>(17 + f)].x = out[f];
  for (const double each : path_pops(thrust, time)) EXPECT_LT(each, 0.1);
  pop[17].y = 0.3;
  EXPECT_NEAR(path_pops(pop, time)[17], 0.3, kTolerance);
}

TEST(PathPops, FourFramesTellNothing) {
  for (const double pop : path_pops(std::vector<glm::dvec3>(4), {0, 1, 2, 3}))
    EXPECT_TRUE(std::isnan(pop));
}

}  // namespace
}  // namespace backbend::validate
