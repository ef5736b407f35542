#include "skin/anatomy/chain_arc.h"

#include <gtest/gtest.h>

#include <glm/geometric.hpp>
#include <vector>

namespace backbend::skin {
namespace {

// Bones of length 3, 0, 4 and 12, each square to the others.
const std::vector<glm::dvec3> kChain = {{1, 1, 1}, {4, 1, 1}, {4, 1, 1}, {4, 5, 1}, {4, 5, 13}};

TEST(ChainArc, PointAtGoesAlongTheBonesByLength) {
  EXPECT_EQ(arc_length(kChain), 19.0);
  const struct {
    double arc;
    glm::dvec3 at;
  } cases[] = {{0, {1, 1, 1}}, {1.5, {2.5, 1, 1}}, {3, {4, 1, 1}},   {5, {4, 3, 1}},
               {7, {4, 5, 1}}, {10, {4, 5, 4}},    {19, {4, 5, 13}}, {19.5, {4, 5, 13}}};
  for (const auto& c : cases)
    EXPECT_LT(glm::distance(point_at(kChain, c.arc / 19.0), c.at), 1e-14) << c.arc;
}

TEST(ChainArc, NearestIsWherePointsAsideWereTakenFrom) {
  EXPECT_NEAR(nearest_arc(kChain, {2.5, 0.5, 0.6}), 1.5, 1e-14);
  EXPECT_NEAR(nearest_arc(kChain, {4.3, 3.0, 0.8}), 5.0, 1e-14);
  EXPECT_NEAR(nearest_arc(kChain, {4.5, 5.5, 9.0}), 15.0, 1e-14);
  EXPECT_EQ(nearest_arc(kChain, {-3, 1, 1}), 0.0);
  EXPECT_NEAR(nearest_arc(kChain, {4, 5, 20}), 19.0, 1e-14);
  EXPECT_EQ(nearest_arc(std::vector{kChain[0]}, {3, 2, 1}), 0.0);
  // As near to the first bone as to the last: the first.
  const std::vector<glm::dvec3> fork = {{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}};
  EXPECT_EQ(nearest_arc(fork, {0.5, 1, 0}), 0.5);
}

}  // namespace
}  // namespace backbend::skin
