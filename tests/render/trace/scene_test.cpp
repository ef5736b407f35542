#include "render/trace/scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "render/image/exr.h"
#include "render/trace/cameras.h"
#include "tests/render/mesh_fixture.h"

namespace backbend::render {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

Settings small(Mode mode, int samples = 4) {
  Settings settings;
  settings.mode = mode;
  settings.samples = samples;
  settings.width = 64;
  settings.height = 48;
  return settings;
}

Camera front_of(const TestMesh& mesh) {
  return view_camera("front", bounds_of(mesh.position), {}, 64.0 / 48.0);
}

TEST(Scene, GivesTheSameBytesForAnyNumberOfThreads) {
  const TestMesh mesh = torus(1.0f, 0.4f, 24);
  Scene scene(mesh.topology);
  scene.set_pose(mesh.pose());
  for (const Mode mode :
       {Mode::clay, Mode::beauty, Mode::ao, Mode::primary, Mode::contour, Mode::xray}) {
    Settings settings = small(mode);
    settings.all_layers = true;
    settings.threads = 1;
    const auto one = encode_exr(scene.render(front_of(mesh), settings));
    for (const int threads : {2, 3, 8, 16}) {
      settings.threads = threads;
      EXPECT_EQ(encode_exr(scene.render(front_of(mesh), settings)), one)
          << "mode " << static_cast<int>(mode) << ", " << threads << " threads";
    }
  }
}

// Tiles of another size put other rays beside each other into packets, and other pixels into one
// batch: neither may be seen.
TEST(Scene, GivesTheSameBytesForAnySizeOfTiles) {
  const TestMesh mesh = blob_figure();
  Scene scene(mesh.topology);
  scene.set_pose(mesh.pose());
  for (const Mode mode : {Mode::clay, Mode::beauty, Mode::wireframe, Mode::ao, Mode::primary,
                          Mode::contour, Mode::xray, Mode::matcap}) {
    // Three samples fill no batch, 40 more than one of any size; neither is a power of two.
    for (const int samples : {1, 3, 40}) {
      Settings settings = small(mode, samples);
      settings.width = 67;  // no multiple of any tile
      settings.height = 51;
      settings.all_layers = true;
      const auto expected = encode_exr(scene.render(front_of(mesh), settings));
      for (const int size : {8, 4}) {
        settings.tile_size = size;
        EXPECT_EQ(encode_exr(scene.render(front_of(mesh), settings)), expected)
            << "mode " << static_cast<int>(mode) << ", " << samples << " samples, tiles of "
            << size;
      }
    }
  }
}

TEST(Scene, GivesTheSameBytesForAnySizeOfTilesWhereSamplingIsAdaptive) {
  const TestMesh mesh = blob_figure();
  Scene scene(mesh.topology);
  scene.set_pose(mesh.pose());
  Settings settings = small(Mode::clay, 64);
  settings.noise = 0.02;
  const auto expected = encode_exr(scene.render(front_of(mesh), settings));
  settings.tile_size = 4;
  EXPECT_EQ(encode_exr(scene.render(front_of(mesh), settings)), expected);
}

TEST(Scene, ShowsTheSamePictureWithoutMattes) {
  const TestMesh mesh = blob_figure();
  Scene scene(mesh.topology);
  scene.set_pose(mesh.pose());
  for (const Mode mode : {Mode::clay, Mode::beauty, Mode::heat}) {
    Settings settings = small(mode, 16);
    settings.noise = 0.02;
    const Frame whole = scene.render(front_of(mesh), settings);
    settings.mattes = false;
    const Frame frame = scene.render(front_of(mesh), settings);
    EXPECT_EQ(frame.layers.size() + 6, whole.layers.size());
    for (const char* layer : {"R", "Z", "N.X"})
      EXPECT_EQ(frame.find(layer)->data, whole.find(layer)->data) << layer;
  }
}

TEST(Scene, ForgetsEarlierPoses) {
  const TestMesh mesh = blob_figure(), last = bent(mesh, 0.7f);
  const Settings settings = small(Mode::clay);
  Scene fresh(mesh.topology), used(mesh.topology);
  fresh.set_pose(last.pose());
  for (const float angle : {2.5f, -1.5f, 0.1f}) {
    const TestMesh earlier = bent(mesh, angle);
    used.set_pose(earlier.pose());
  }
  used.set_pose(last.pose());
  EXPECT_EQ(encode_exr(used.render(front_of(mesh), settings)),
            encode_exr(fresh.render(front_of(mesh), settings)));
}

// The tree of a scene that was built in the pose has another shape than one refitted from rest, so
// this also holds the order of the tree's leaves out of the picture.
TEST(Scene, SeesARefittedPoseAsOneItWasBuiltIn) {
  const TestMesh mesh = blob_figure(), pose = bent(mesh, 1.8f);
  auto rebuilt_topology = std::make_shared<MeshTopology>(*mesh.topology);
  rebuilt_topology->rest_position = pose.position;
  Scene refitted(mesh.topology), rebuilt(rebuilt_topology);
  refitted.set_pose(pose.pose());
  rebuilt.set_pose(pose.pose());
  Settings settings = small(Mode::primary, 16);
  settings.width = 256;
  settings.height = 192;
  const Camera camera = view_camera("profile", bounds_of(pose.position), {}, 4.0 / 3.0);
  EXPECT_EQ(encode_exr(refitted.render(camera, settings)),
            encode_exr(rebuilt.render(camera, settings)));
}

TEST(Scene, GivesEqualHitsToTheLowestTriangle) {
  TestMesh mesh = square(1.0f);
  auto topology = std::make_shared<MeshTopology>(*mesh.topology);
  topology->triangle.clear();
  // Forty copies of one square: every ray meets forty triangles at one distance.
  for (int copy = 0; copy < 40; ++copy)
    for (const glm::uvec3& t : mesh.topology->triangle) topology->triangle.push_back(t);
  topology->triangle_material.assign(topology->triangle.size(), 0);
  Scene scene(topology);
  scene.set_pose(mesh.pose());
  Settings settings = small(Mode::primary, 1);
  settings.all_layers = true;
  const Frame frame = scene.render(front_of(mesh), settings);
  int hits = 0, lowest = 0;
  for (const float id : frame.find("triangleId")->data) {
    hits += id > 0.0f;
    lowest += id == 1.0f || id == 2.0f;
  }
  EXPECT_GT(hits, 100);
  EXPECT_EQ(lowest, hits);
}

TEST(Scene, ChangesItsNoiseAndNothingElseWithTheSeed) {
  const TestMesh mesh = torus(1.0f, 0.4f, 16);
  Scene scene(mesh.topology);
  scene.set_pose(mesh.pose());
  Settings settings = small(Mode::clay, 2);
  const Frame first = scene.render(front_of(mesh), settings);
  settings.seed = 1;
  const Frame second = scene.render(front_of(mesh), settings);
  EXPECT_NE(first.find("R")->data, second.find("R")->data);
  EXPECT_EQ(first.find("Z")->data, second.find("Z")->data);
  EXPECT_EQ(first.find("N.X")->data, second.find("N.X")->data);
}

TEST(Scene, RefusesNumbersThatAreNotFinite) {
  TestMesh mesh = square(1.0f);
  Scene scene(mesh.topology);
  mesh.position[2].y = kNaN;
  EXPECT_THROW(scene.set_pose(mesh.pose()), RenderError);
  mesh.position[2].y = 0.5f;
  mesh.normal[0].x = std::numeric_limits<float>::infinity();
  EXPECT_THROW(scene.set_pose(mesh.pose()), RenderError);
  auto topology = std::make_shared<MeshTopology>(*mesh.topology);
  topology->rest_position[1].z = kNaN;
  EXPECT_THROW(Scene{topology}, RenderError);
}

TEST(Scene, RefusesAMeshItCannotShow) {
  EXPECT_THROW(Scene(std::make_shared<MeshTopology>()), RenderError);
  EXPECT_THROW(Scene(nullptr), RenderError);
  const TestMesh mesh = square(1.0f);
  const auto broken = [&](auto change) {
    auto topology = std::make_shared<MeshTopology>(*mesh.topology);
    change(*topology);
    return topology;
  };
  EXPECT_THROW(Scene(broken([](auto& t) { t.triangle[1].z = 4; })), RenderError);
  EXPECT_THROW(Scene(broken([](auto& t) { t.vertex_region[0] = 1; })), RenderError);
  EXPECT_THROW(Scene(broken([](auto& t) { t.triangle_material[0] = 1; })), RenderError);
  EXPECT_THROW(Scene(broken([](auto& t) { t.materials[0].base_color_texture = 0; })), RenderError);
  EXPECT_THROW(Scene(broken([](auto& t) { t.uv.resize(3); })), RenderError);
  EXPECT_THROW(Scene(broken([](auto& t) { t.rest_position.assign(4, glm::vec3(1.0f)); })),
               RenderError);
}

TEST(Scene, RefusesAPoseOfAnotherMesh) {
  const TestMesh mesh = square(1.0f), other = torus(1.0f, 0.4f, 8);
  Scene scene(mesh.topology);
  EXPECT_THROW(scene.set_pose(other.pose()), RenderError);
  EXPECT_THROW(scene.render(front_of(mesh), small(Mode::clay)), RenderError) << "no pose was set";
}

TEST(Scene, RefusesSettingsAndCamerasWithoutAPicture) {
  const TestMesh mesh = square(1.0f);
  Scene scene(mesh.topology);
  scene.set_pose(mesh.pose());
  const auto render = [&](auto change, Camera camera) {
    Settings settings = small(Mode::primary, 1);
    change(settings);
    return scene.render(camera, settings);
  };
  const Camera good = front_of(mesh);
  EXPECT_THROW(render([](Settings& s) { s.width = 0; }, good), RenderError);
  EXPECT_THROW(render([](Settings& s) { s.height = 100'000; }, good), RenderError);
  EXPECT_THROW(render([](Settings& s) { s.samples = 0; }, good), RenderError);
  EXPECT_THROW(render([](Settings& s) { s.bounces = -1; }, good), RenderError);
  EXPECT_THROW(render([](Settings& s) { s.environment_file = "/nowhere.hdr"; }, good), RenderError);
  Camera camera = good;
  camera.target = camera.eye;
  EXPECT_THROW(render([](Settings&) {}, camera), RenderError);
  camera = good;
  camera.up = camera.target - camera.eye;
  EXPECT_THROW(render([](Settings&) {}, camera), RenderError);
  camera = good;
  camera.eye.x = kNaN;
  EXPECT_THROW(render([](Settings&) {}, camera), RenderError);
  camera = good;
  camera.focal_mm = 0.0;
  EXPECT_THROW(render([](Settings&) {}, camera), RenderError);
}

TEST(Scene, ShowsATriangleWithoutAreaAsNothingWrong) {
  TestMesh mesh = square(1.0f);
  auto topology = std::make_shared<MeshTopology>(*mesh.topology);
  topology->triangle.push_back({0, 0, 1});  // a line
  topology->triangle.push_back({2, 2, 2});  // a point
  topology->triangle_material.assign(4, 0);
  Scene scene(topology);
  scene.set_pose(mesh.pose());
  const Frame frame = scene.render(front_of(mesh), small(Mode::clay));
  for (const Layer& layer : frame.layers)
    for (const float value : layer.data) ASSERT_TRUE(std::isfinite(value)) << layer.names[0];
}

}  // namespace
}  // namespace backbend::render
