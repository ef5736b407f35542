#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>

#include "render/image/cryptomatte.h"
#include "render/trace/cameras.h"
#include "render/trace/projection.h"
#include "tests/render/mesh_fixture.h"

namespace backbend::render {
namespace {

Settings geometry_only(int width, int height) {
  Settings settings;
  settings.mode = Mode::primary;
  settings.samples = 1;
  settings.width = width;
  settings.height = height;
  settings.all_layers = true;
  return settings;
}

// Looking along -Z at the origin: half the film is tan 18/50 at unit distance.
Camera along_z(double distance) {
  Camera camera;
  camera.eye = {0, 0, distance};
  camera.target = {0, 0, 0};
  return camera;
}

Frame shoot(const TestMesh& mesh, const PoseGeometry& pose, const Camera& camera,
            const Settings& settings) {
  Scene scene(mesh.topology);
  scene.set_pose(pose);
  return scene.render(camera, settings);
}

TEST(Layers, CoverHalfTheFrameWithASquareThatFillsHalf) {
  // At distance 2 the frame is 2 * 2 * 18/50 = 1.44 wide and, at 100 x 100, as tall.
  const TestMesh mesh = square(0.72f);
  const Frame frame = shoot(mesh, mesh.pose(), along_z(2.0), geometry_only(100, 100));
  int covered = 0;
  for (int y = 0; y < 100; ++y) {
    for (int x = 0; x < 100; ++x) {
      const float depth = frame.find("Z")->data[y * 100 + x];
      const bool inside = x >= 25 && x < 75 && y >= 25 && y < 75;
      if (inside) {
        EXPECT_NEAR(depth, 2.0f, 1e-6f) << x << ", " << y;  // along the axis, not along the ray
        ++covered;
      } else {
        EXPECT_EQ(depth, 1e10f) << x << ", " << y;
      }
    }
  }
  EXPECT_EQ(covered, 2500);
}

TEST(Layers, ShowASphereWithItsNormalsAndOutline) {
  const TestMesh mesh = sphere({0, 0, 0}, 1.0f, 96);
  const double distance = 4.0;
  const Frame frame = shoot(mesh, mesh.pose(), along_z(distance), geometry_only(160, 160));
  const Layer& position = *frame.find("P.X");
  const Layer& normal = *frame.find("N.X");
  double area = 0.0;
  for (std::size_t p = 0; p < 160 * 160; ++p) {
    if (frame.find("Z")->data[p] > 1e9f) continue;
    area += 1.0;
    const glm::vec3 at(position.data[p * 3], position.data[p * 3 + 1], position.data[p * 3 + 2]);
    const glm::vec3 n(normal.data[p * 3], normal.data[p * 3 + 1], normal.data[p * 3 + 2]);
    // 96 rings: a chord lies at most 1 - cos(pi/96) = 5.4e-4 inside the sphere.
    EXPECT_NEAR(glm::length(at), 1.0f, 6e-4f);
    EXPECT_GT(glm::dot(n, at / glm::length(at)), 0.9999f);
  }
  // The outline of a ball at distance d is seen under asin(1/d).
  const double radius = std::tan(std::asin(1.0 / distance)) / (18.0 / 50.0) * 80.0;
  EXPECT_NEAR(area, std::numbers::pi * radius * radius, 0.005 * area);
}

TEST(Layers, PutEveryPointWhereWorldToNdcSaysItIs) {
  const TestMesh mesh = bent(blob_figure(), 0.8f);
  Settings settings = geometry_only(96, 64);
  const Camera camera = view_camera("three_quarter", bounds_of(mesh.position), {}, 1.5);
  const Frame frame = shoot(mesh, mesh.pose(), camera, settings);
  int seen = 0;
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 96; ++x) {
      const std::size_t p = static_cast<std::size_t>(y) * 96 + x;
      if (frame.find("Z")->data[p] > 1e9f) continue;
      const float* at = frame.find("P.X")->data.data() + p * 3;
      const glm::dvec4 ndc = frame.ndc_from_world * glm::dvec4(at[0], at[1], at[2], 1.0);
      EXPECT_NEAR(ndc.x / ndc.w * 96.0, x + 0.5, 0.51);
      EXPECT_NEAR(ndc.y / ndc.w * 64.0, y + 0.5, 0.51);
      const glm::dvec4 in_camera = frame.camera_from_world * glm::dvec4(at[0], at[1], at[2], 1.0);
      EXPECT_NEAR(-in_camera.z, frame.find("Z")->data[p], 1e-5);
      ++seen;
    }
  }
  EXPECT_GT(seen, 300);
}

TEST(Layers, MeasureMotionInPixelsToTheEarlierPlace) {
  const TestMesh mesh = square(0.72f);
  std::vector<glm::vec3> before = mesh.position;
  // At distance 2 and 100 pixels for 1.44 units, a tenth of a pixel is 0.00144.
  for (glm::vec3& p : before) p += glm::vec3(0.0144f * 3.0f, 0.0144f * 2.0f, 0.0f);
  PoseGeometry pose = mesh.pose();
  pose.previous_position = before;
  const Frame frame = shoot(mesh, pose, along_z(2.0), geometry_only(100, 100));
  const float* motion = frame.find("motion.X")->data.data() + (50 * 100 + 50) * 2;
  EXPECT_NEAR(motion[0], 3.0f, 1e-4f);
  EXPECT_NEAR(motion[1], -2.0f, 1e-4f);  // up on the film is towards smaller y
}

TEST(Layers, KeepTheRestPositionOfAMovedPoint) {
  const TestMesh mesh = blob_figure(), pose = bent(mesh, 1.0f);
  const Camera camera = view_camera("front", bounds_of(pose.position), {}, 1.0);
  const Frame frame = shoot(mesh, pose.pose(), camera, geometry_only(64, 64));
  const auto& triangle_id = frame.find("triangleId")->data;
  for (std::size_t p = 0; p < triangle_id.size(); ++p) {
    if (triangle_id[p] == 0.0f) continue;
    // The point lies inside the box of its triangle at rest.
    const glm::uvec3 t = mesh.topology->triangle[static_cast<std::size_t>(triangle_id[p]) - 1];
    const float* rest = frame.find("Pref.X")->data.data() + p * 3;
    for (int c = 0; c < 3; ++c) {
      const float a = mesh.position[t.x][c], b = mesh.position[t.y][c], d = mesh.position[t.z][c];
      EXPECT_GE(rest[c], std::min({a, b, d}) - 1e-5f);
      EXPECT_LE(rest[c], std::max({a, b, d}) + 1e-5f);
    }
  }
}

TEST(Layers, ShareAPixelsMatteAmongItsRegions) {
  const TestMesh mesh = torus(1.0f, 0.4f, 48);
  Settings settings = geometry_only(64, 64);
  settings.samples = 64;
  const Camera camera = view_camera("front", bounds_of(mesh.position), {}, 1.0);
  const Frame frame = shoot(mesh, mesh.pose(), camera, settings);
  const float torso = cryptomatte_id("torso"), arm = cryptomatte_id("arm_L");
  double torso_area = 0.0, arm_area = 0.0;
  for (std::size_t p = 0; p < 64 * 64; ++p) {
    const float* region = frame.find("CryptoObject00.r")->data.data() + p * 4;
    const float* object = frame.find("CryptoAsset00.r")->data.data() + p * 4;
    EXPECT_GE(region[1], region[3]) << "ranks fall";
    EXPECT_FLOAT_EQ(region[1] + region[3], object[1]);
    EXPECT_FLOAT_EQ(object[1], frame.find("R")->data[p * 4 + 3]) << "coverage is the alpha";
    for (const int rank : {0, 2}) {
      if (region[rank] == torso) torso_area += region[rank + 1];
      if (region[rank] == arm) arm_area += region[rank + 1];
    }
    if (object[1] > 0.0f) {
      EXPECT_EQ(object[0], cryptomatte_id("figure"));
    }
  }
  EXPECT_GT(torso_area, 200.0);
  EXPECT_NEAR(torso_area / arm_area, 1.0, 0.05);  // the torus is halved in the middle
}

TEST(Layers, CarryHeatAndSayWhereNoneWasMeasured) {
  const TestMesh mesh = square(1.0f);
  std::vector<float> heat{0.0f, 1.0f, 1.0f, 0.0f};  // grows with x
  PoseGeometry pose = mesh.pose();
  pose.heat = heat;
  Settings settings = geometry_only(64, 64);
  settings.mode = Mode::heat;
  const Frame frame = shoot(mesh, pose, along_z(2.0), settings);
  const std::size_t center = 32 * 64 + 32;
  const float x = frame.find("P.X")->data[center * 3];
  EXPECT_NEAR(frame.find("heat")->data[center], x + 0.5f, 1e-5f);
  heat.assign(4, std::numeric_limits<float>::quiet_NaN());
  const Frame unmeasured = shoot(mesh, pose, along_z(2.0), settings);
  EXPECT_TRUE(std::isnan(unmeasured.find("heat")->data[center]));
  const float* color = unmeasured.find("R")->data.data() + center * 4;
  EXPECT_GT(color[0], 2.0f * color[1]) << "magenta, which the scale does not hold";
  EXPECT_GT(color[2], 2.0f * color[1]);
}

TEST(Layers, LeaveOutWhatWasNotAskedFor) {
  const TestMesh mesh = square(1.0f);
  Settings settings = geometry_only(8, 8);
  settings.all_layers = false;
  const Frame frame = shoot(mesh, mesh.pose(), along_z(2.0), settings);
  EXPECT_NE(frame.find("R"), nullptr);
  EXPECT_NE(frame.find("Z"), nullptr);
  EXPECT_NE(frame.find("N.X"), nullptr);
  EXPECT_NE(frame.find("CryptoAsset00.r"), nullptr);
  EXPECT_NE(frame.find("CryptoObject02.r"), nullptr);
  EXPECT_EQ(frame.find("P.X"), nullptr);
  settings.position_and_albedo = true;
  const Frame more = shoot(mesh, mesh.pose(), along_z(2.0), settings);
  EXPECT_NE(more.find("P.X"), nullptr);
  EXPECT_NE(more.find("albedo.R"), nullptr);
  EXPECT_EQ(more.find("Pref.X"), nullptr);
}

}  // namespace
}  // namespace backbend::render
