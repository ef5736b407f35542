#include "solver/rig/controllers.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>

namespace backbend::solver {
namespace {

const RestChain kStraight{{{0, 0, 0}, {0, 2, 0}, {0, 4, 0}, {0, 6, 0}}, {1, 0, 0}};

TEST(ControllerShapes, AreOneSquarePerBoneWithItsLengthForAnEdge) {
  const auto system = build_system({"curve", {}}, kStraight);
  const std::vector<double> rest(system->channels().size(), 0.0);
  const std::vector<ControllerShape> shapes = controller_shapes(*system, kStraight, rest);
  ASSERT_EQ(shapes.size(), 3u);
  for (std::size_t bone = 0; bone < 3; ++bone) {
    EXPECT_EQ(shapes[bone].color, static_cast<int>(bone));
    for (int edge = 0; edge < 4; ++edge) {
      const auto& line = shapes[bone].line[static_cast<std::size_t>(edge)];
      EXPECT_NEAR(glm::distance(line[0], line[1]), 2.0, 1e-12);
      EXPECT_NEAR(line[0].y, 2.0 * static_cast<double>(bone), 1e-12)
          << "the square does not lie across the bone";
    }
    // The arrow points forward, +Z on an upright spine.
    const glm::dvec3 arrow = shapes[bone].line[4][1] - shapes[bone].line[4][0];
    EXPECT_GT(arrow.z, 1.0);
    EXPECT_NEAR(arrow.x, 0.0, 1e-12);
  }
}

TEST(ControllerShapes, TurnWithTheirControl) {
  const auto system = build_system({"curve", {}}, kStraight);
  const double quarter = std::acos(-1.0) / 2.0;
  const std::vector<double> control = system->controls_for({quarter, 0, 0, 0}, Mapping::chest);
  const std::vector<ControllerShape> shapes = controller_shapes(*system, kStraight, control);
  // A backbend of 90 degrees on Top turns its forward arrow from +Z to +Y.
  const glm::dvec3 arrow = shapes[2].line[4][1] - shapes[2].line[4][0];
  EXPECT_NEAR(arrow.z, 0.0, 1e-9);
  EXPECT_GT(arrow.y, 1.0);
  // Lower has not moved.
  EXPECT_GT((shapes[0].line[4][1] - shapes[0].line[4][0]).z, 1.0);
}

TEST(ControllerShapes, ExistForEverySystem) {
  for (const SystemInfo& info : list_systems()) {
    const auto system = build_system({std::string(info.name), {}}, kStraight);
    const std::vector<double> control = system->controls_for({0.5, 0, 0.2, 0.1}, Mapping::spread);
    const std::vector<ControllerShape> shapes = controller_shapes(*system, kStraight, control);
    EXPECT_GE(shapes.size(), 2u) << info.name;
    for (const ControllerShape& shape : shapes) {
      for (const auto& line : shape.line) {
        EXPECT_TRUE(
            std::isfinite(line[0].x + line[0].y + line[0].z + line[1].x + line[1].y + line[1].z))
            << info.name;
        EXPECT_GT(glm::distance(line[0], line[1]), 0.0) << info.name;
      }
    }
  }
}

}  // namespace
}  // namespace backbend::solver
