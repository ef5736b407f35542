#include "skin/character/closest_point.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>

namespace backbend::skin {
namespace {

const glm::dvec3 kA(0, 0, 0), kB(4, 0, 0), kC(0, 3, 0);

glm::dvec3 place(const TrianglePoint& on) {
  return on.share[0] * kA + on.share[1] * kB + on.share[2] * kC;
}

TEST(ClosestOnTriangle, AboveTheFaceItIsTheFootOfThePerpendicular) {
  const TrianglePoint on = closest_on_triangle({1, 1, 2}, kA, kB, kC);
  EXPECT_LT(glm::distance(place(on), glm::dvec3(1, 1, 0)), 1e-12);
  EXPECT_DOUBLE_EQ(on.distance, 2.0);
}

TEST(ClosestOnTriangle, BesideItIsOnTheNearestEdgeOrCorner) {
  TrianglePoint on = closest_on_triangle({1, -2, 0}, kA, kB, kC);
  EXPECT_LT(glm::distance(place(on), glm::dvec3(1, 0, 0)), 1e-12);
  on = closest_on_triangle({9, -1, 0}, kA, kB, kC);
  EXPECT_LT(glm::distance(place(on), kB), 1e-12);
  EXPECT_NEAR(on.distance, std::sqrt(26.0), 1e-12);
  on = closest_on_triangle({4, 3, 0}, kA, kB, kC);  // the long edge
  EXPECT_NEAR(on.distance, 2.4, 1e-12);
  EXPECT_DOUBLE_EQ(on.share[0], 0.0);
}

TEST(ClosestOnTriangle, SharesAddUpToOneAndNoneIsNegative) {
  for (int i = -5; i <= 9; ++i)
    for (int k = -5; k <= 9; ++k) {
      const TrianglePoint on = closest_on_triangle({i, k, 0.5}, kA, kB, kC);
      EXPECT_NEAR(on.share[0] + on.share[1] + on.share[2], 1.0, 1e-12);
      for (const double share : on.share) EXPECT_GE(share, 0.0);
      EXPECT_NEAR(on.distance, glm::distance(place(on), glm::dvec3(i, k, 0.5)), 1e-12);
    }
}

TEST(ClosestOnTriangle, WithoutAreaItIsOnTheEdges) {
  const TrianglePoint on = closest_on_triangle({1, 1, 0}, kA, kB, {2, 0, 0});
  EXPECT_NEAR(on.distance, 1.0, 1e-12);
  EXPECT_NEAR(closest_on_triangle({1, 1, 0}, kA, kA, kA).distance, std::sqrt(2.0), 1e-12);
}

}  // namespace
}  // namespace backbend::skin
