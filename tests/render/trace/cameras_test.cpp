#include "render/trace/cameras.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "render/trace/projection.h"

namespace backbend::render {
namespace {

const Bounds kBox{{-0.8, 0.0, -0.3}, {0.6, 1.8, 0.5}};

TEST(Cameras, HoldTheWholeBoxAndFillTheFrameWithIt) {
  for (const std::string_view name : view_names()) {
    for (const double aspect : {0.5, 1.0, 16.0 / 9.0}) {
      const int width = static_cast<int>(900 * aspect);
      const Projection p = project_camera(view_camera(name, kBox, {}, aspect), width, 900);
      double extent = 0.0;
      for (int corner = 0; corner < 8; ++corner) {
        const glm::dvec3 on_film =
            p.project({corner & 1 ? kBox.high.x : kBox.low.x, corner & 2 ? kBox.high.y : kBox.low.y,
                       corner & 4 ? kBox.high.z : kBox.low.z});
        extent = std::max({extent, std::abs(2.0 * on_film.x / width - 1.0),
                           std::abs(2.0 * on_film.y / 900.0 - 1.0)});
      }
      EXPECT_LT(extent, 1.0) << name << ' ' << aspect;
      EXPECT_GT(extent, 0.9) << name << ' ' << aspect;
    }
  }
}

// Pins the axes: the character faces +Z, its left is +X.
TEST(Cameras, StandWhereTheirNamesSay) {
  const auto side = [](std::string_view name) {
    const Camera c = view_camera(name, kBox, {}, 1.0);
    return glm::normalize(c.eye - c.target);
  };
  EXPECT_EQ(view_names().front(), "profile");
  EXPECT_GT(side("profile").x, 0.99);
  EXPECT_GT(side("front").z, 0.99);
  EXPECT_LT(side("back").z, -0.99);
  EXPECT_LT(side("three_quarter").z, -0.7);
  EXPECT_GT(side("three_quarter").x, 0.4);
}

TEST(Cameras, FollowACharacterThatFacesElsewhere) {
  const Facing z_up{{0, 0, 1}, {0, -1, 0}};
  EXPECT_NEAR(z_up.left().x, 1.0, 1e-12);
  const Camera c = view_camera("front", kBox, z_up, 1.0);
  EXPECT_LT(glm::normalize(c.eye - c.target).y, -0.99);
}

TEST(Cameras, NameTheNearestViewInTheError) {
  try {
    view_camera("profil", kBox, {}, 1.0);
    FAIL();
  } catch (const RenderError& error) {
    EXPECT_NE(std::string(error.what()).find("'profile'"), std::string::npos);
  }
}

TEST(Cameras, RefuseToFrameNothing) {
  EXPECT_THROW(view_camera("front", Bounds{}, {}, 1.0), RenderError);
  EXPECT_THROW(view_camera("front", {{1, 1, 1}, {1, 1, 1}}, {}, 1.0), RenderError);
  EXPECT_THROW(view_camera("front", kBox, {}, std::nan("")), RenderError);
  EXPECT_THROW(view_camera("front", kBox, {{0, 1, 0}, {0, 1, 0}}, 1.0), RenderError);
  EXPECT_THROW(close_up("front", {0, 0, 0}, 0.0, {}, 1.0), RenderError);
  EXPECT_THROW(turntable(0, kBox, {}, 1.0), RenderError);
}

TEST(Turntable, ClosesWithoutRepeatingItsFirstView) {
  const auto cameras = turntable(72, kBox, {}, 1.5);
  ASSERT_EQ(cameras.size(), 72u);
  const double step = glm::length(cameras[1].eye - cameras[0].eye);
  for (std::size_t i = 0; i < 72; ++i) {
    const Camera& now = cameras[i];
    const Camera& next = cameras[(i + 1) % 72];
    EXPECT_NEAR(glm::length(next.eye - now.eye), step, 1e-9 * step) << i;
    EXPECT_NEAR(glm::length(now.eye - now.target), glm::length(cameras[0].eye - now.target), 1e-9);
    EXPECT_NEAR(now.eye.y, cameras[0].eye.y, 1e-12) << "one height";
  }
  EXPECT_GT(cameras[18].eye.x, 1.0) << "a quarter on, the character's left";
}

TEST(CloseUp, FillsTheFrameWithTheBall) {
  const glm::dvec3 point(0.2, 1.1, 0.3);
  const Camera c = close_up("back", point, 0.1, {}, 1.5);
  const double distance = glm::length(c.eye - point);
  const double seen = std::tan(std::asin(0.1 / distance)) / (0.36 / 1.5);  // of half the height
  EXPECT_GT(seen, 0.9);
  EXPECT_LT(seen, 1.0);
}

}  // namespace
}  // namespace backbend::render
