// Point caches in other units and axes than the body's.
#include "validate/clips/point_space.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <vector>

#include "validate/metrics/math/rotation.h"

namespace backbend::validate {
namespace {

/// Points that no turn takes onto each other.
std::vector<glm::vec3> body_points() {
  std::vector<glm::vec3> out;
  for (int i = 0; i < 60; ++i)
    out.emplace_back(0.3 * std::sin(1.7 * i), 0.03 * i, 0.1 * std::cos(0.9 * i) + 0.002 * i);
  return out;
}

/// As a program with other axes and another unit would write them, posed by a turn.
std::vector<glm::vec3> written(const std::vector<glm::vec3>& body, const PointSpace& space,
                               const glm::dquat& pose) {
  std::vector<glm::vec3> out;
  for (const glm::vec3& p : body)
    out.emplace_back(glm::transpose(space.turn) * (pose * glm::dvec3(p)) / space.scale);
  return out;
}

TEST(PointSpace, EverySpaceIsToldInRestAndInAnyNearPose) {
  const std::vector<glm::vec3> rest = body_points();
  for (const PointSpace& space : point_spaces())
    for (const glm::dvec3& turn : {glm::dvec3(0), glm::dvec3(0.5, 0, 0), glm::dvec3(0, 0.4, 0.3)})
      for (const double stretch : {1.0, 0.93, 1.1}) {
        const std::vector<glm::vec3> frame = written(rest, space, rotation(turn));
        const PointSpace& found = space_in_order(rest, frame, stretch / space.scale);
        EXPECT_EQ(found.scale, space.scale) << space.note;
        EXPECT_EQ(found.note, space.note);
        EXPECT_EQ(found.differs(), &space != &point_spaces().front());
        if (turn != glm::dvec3(0)) continue;
        for (std::size_t v = 0; v < rest.size(); ++v)
          EXPECT_LT(glm::distance(found.to_body(frame[v]), rest[v]), 1e-5) << space.note;
      }
}

TEST(PointSpace, ABodyThatLiesDownInItsOwnAxesKeepsThem) {
  const std::vector<glm::vec3> rest = body_points();
  const PointSpace& own = point_spaces().front();
  for (const glm::dvec3& turn : {glm::dvec3(-kPi / 2, 0, 0), glm::dvec3(0, 0, kPi / 2),
                                 glm::dvec3(0, kPi / 2, 0), glm::dvec3(kPi, 0, 0)})
    EXPECT_FALSE(space_in_order(rest, written(rest, own, rotation(turn)), 1.0).differs());
}

TEST(PointSpace, NoUnitIsGuessedThatIsFarFromTheRatio) {
  const std::vector<glm::vec3> rest = body_points();
  EXPECT_EQ(space_in_order(rest, rest, 3.0).scale, 1.0);
  EXPECT_EQ(space_in_order(rest, rest, 1.2).scale, 1.0);
}

}  // namespace
}  // namespace backbend::validate
