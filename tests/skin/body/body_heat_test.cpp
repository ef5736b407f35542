// Heat on a flat sheet, where what it does is known: it is kept, and spreads by its reach.
#include "skin/body/body_heat.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <span>

namespace backbend::skin {
namespace {

constexpr double kSolved = 1e-6;  // equations are solved until a ten-millionth is left
constexpr double kStep = 0.05;
constexpr int kWide = 24, kTall = 48;  // of the half: its mirror image makes it a square

/// A flat sheet in the X-Y plane, x from 0; every square is cut in two.
HalfMesh sheet() {
  HalfMesh half;
  for (int y = 0; y <= kTall; ++y)
    for (int x = 0; x <= kWide; ++x) half.position.emplace_back(kStep * x, kStep * y, 0.0);
  const auto at = [](int x, int y) { return y * (kWide + 1) + x; };
  for (int y = 0; y < kTall; ++y)
    for (int x = 0; x < kWide; ++x) {
      half.triangle.push_back({at(x, y), at(x + 1, y), at(x + 1, y + 1)});
      half.triangle.push_back({at(x, y), at(x + 1, y + 1), at(x, y + 1)});
    }
  return half;
}

TEST(WholeMesh, IsTheHalfAndItsMirrorImageJoinedInThePlane) {
  const HalfMesh half = sheet();
  const WholeMesh whole = whole_mesh(half);
  ASSERT_EQ(whole.position.size(), std::size_t{(2 * kWide + 1) * (kTall + 1)});
  double area = 0.0;
  std::size_t sides = 0;
  for (std::size_t v = 0; v < whole.position.size(); ++v) {
    const glm::dvec3 p = whole.position[v];
    const auto twin = static_cast<std::size_t>(whole.twin[v]);
    EXPECT_EQ(whole.position[twin], glm::dvec3(-p.x, p.y, p.z));
    EXPECT_EQ(whole.twin[twin], static_cast<int>(v));
    EXPECT_DOUBLE_EQ(whole.area[twin], whole.area[v]);
    area += whole.area[v];
    sides += whole.edges[v].size();
    const bool inside =
        std::abs(p.x) < kStep * (kWide - 0.5) && p.y > 0.5 * kStep && p.y < kStep * (kTall - 0.5);
    for (const Edge& e : whole.edges[v]) {
      const glm::dvec3 along = whole.position[static_cast<std::size_t>(e.to)] - p;
      // Squares: half of each cotangent of 45 degrees on both sides, none across the square.
      const bool diagonal = std::abs(along.x * along.y) > 0.0;
      EXPECT_GE(e.cotangent, 0.02);
      if (inside) {
        EXPECT_NEAR(e.cotangent, diagonal ? 0.02 : 1.0, 1e-12);
      }
    }
  }
  EXPECT_NEAR(area, 2.0 * kWide * kTall * kStep * kStep, 1e-12);
  // Euler: a disc has V - E + F = 1, and every edge is known from both its ends.
  EXPECT_EQ(whole.position.size() - sides / 2 + 2 * half.triangle.size(), 1u);
}

TEST(BodyHeat, IsKeptAndSpreadsAPointByItsReach) {
  const WholeMesh whole = whole_mesh(sheet());
  for (const double reach : {0.1, 0.2}) {
    const BodyHeat heat(whole, std::vector<double>(whole.position.size(), reach));
    std::vector<double> value(whole.position.size(), 0.0);
    const glm::dvec3 middle(0.0, 0.5 * kStep * kTall, 0.0);
    for (std::size_t v = 0; v < value.size(); ++v)
      if (glm::distance(whole.position[v], middle) < 1e-9) value[v] = 1.0 / whole.area[v];
    heat.spread(std::span(&value, 1));
    double sum = 0.0, across = 0.0, along = 0.0;
    for (std::size_t v = 0; v < value.size(); ++v) {
      EXPECT_GE(value[v], 0.0);
      const glm::dvec3 off = whole.position[v] - middle;
      sum += whole.area[v] * value[v];
      across += whole.area[v] * value[v] * off.x * off.x;
      along += whole.area[v] * value[v] * off.y * off.y;
      EXPECT_NEAR(value[v], value[static_cast<std::size_t>(whole.twin[v])], kSolved);
    }
    EXPECT_NEAR(sum, 1.0, kSolved);
    // Each end of the cut across a square weighs 0.02 where an edge weighs 1: 2 % more.
    EXPECT_NEAR(across, 1.02 * reach * reach, 0.001 * reach * reach) << reach;
    EXPECT_NEAR(along, 1.02 * reach * reach, 0.001 * reach * reach) << reach;
  }
}

TEST(BodyHeat, KeepsWhatIsEvenAndTheRangeOfWhatIsNot) {
  const WholeMesh whole = whole_mesh(sheet());
  std::vector<double> reach;
  for (const glm::dvec3& p : whole.position) reach.push_back(0.05 + 0.1 * p.y);
  const BodyHeat heat(whole, reach);
  std::vector<double> even(whole.position.size(), 0.75), none(whole.position.size(), 0.0), step;
  for (const glm::dvec3& p : whole.position) step.push_back(p.y > 1.2 ? 1.0 : 0.25);
  double before = 0.0, after = 0.0;
  for (std::size_t v = 0; v < step.size(); ++v) before += whole.area[v] * step[v];
  heat.spread(std::span(&even, 1));
  heat.spread(std::span(&none, 1));
  heat.spread(std::span(&step, 1));
  for (std::size_t v = 0; v < step.size(); ++v) {
    EXPECT_NEAR(even[v], 0.75, kSolved);
    EXPECT_EQ(none[v], 0.0);
    EXPECT_GE(step[v], 0.25 - kSolved);
    EXPECT_LE(step[v], 1.0 + kSolved);
    after += whole.area[v] * step[v];
  }
  EXPECT_NEAR(after, before, kSolved);
}

TEST(BodyHeat, SpreadsSeveralValuesTogetherToTheBitsOfEachAlone) {
  const WholeMesh whole = whole_mesh(sheet());
  std::vector<double> reach;
  for (const glm::dvec3& p : whole.position) reach.push_back(0.05 + 0.1 * p.y);
  const BodyHeat heat(whole, reach);
  // They take different numbers of steps to solve.
  std::vector<std::vector<double>> alone(3), together;
  for (const glm::dvec3& p : whole.position) {
    alone[0].push_back(p.y > 1.2 ? 1.0 : 0.25);
    alone[1].push_back(0.0);
    alone[2].push_back(p.x * p.y);
  }
  together = alone;
  heat.spread(together);
  for (auto& value : alone) heat.spread(std::span(&value, 1));
  EXPECT_EQ(together, alone);
}

}  // namespace
}  // namespace backbend::skin
