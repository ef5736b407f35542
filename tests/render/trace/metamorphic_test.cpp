// The same picture in another world: what must stay, and how the rest must follow, when the scene
// is moved, scaled, mirrored, turned, cut up or seen through other random numbers.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <map>
#include <numbers>
#include <numeric>
#include <random>

#include "render/trace/cameras.h"
#include "render/trace/lighting.h"
#include "render/trace/ray_device.h"
#include "render/trace/surface.h"
#include "tests/render/mesh_fixture.h"

namespace backbend::render {
namespace {

Settings settings_of(Mode mode, int samples, int size = 96) {
  Settings settings;
  settings.mode = mode;
  settings.samples = samples;
  settings.width = settings.height = size;
  settings.all_layers = true;
  return settings;
}

Frame shoot(const TestMesh& mesh, const Camera& camera, const Settings& settings) {
  Scene scene(mesh.topology);
  scene.set_pose(mesh.pose());
  return scene.render(camera, settings);
}

std::shared_ptr<const Texture> uniform_sky(float radiance) {
  auto sky = std::make_shared<Texture>();
  sky->width = 16;
  sky->height = 8;
  sky->texel.assign(128, glm::vec4(radiance));
  return sky;
}

/// Every place and every direction of a world through `place` and its linear part `turn`.
struct World {
  std::function<glm::dvec3(const glm::dvec3&)> place, turn;

  TestMesh of(const TestMesh& mesh) const {
    TestMesh moved = mesh;
    for (glm::vec3& p : moved.position) p = glm::vec3(place(glm::dvec3(p)));
    for (glm::vec3& n : moved.normal) n = glm::vec3(turn(glm::dvec3(n)));
    moved.topology = std::make_shared<MeshTopology>(*mesh.topology);
    for (glm::vec3& p : moved.topology->rest_position) p = glm::vec3(place(glm::dvec3(p)));
    return moved;
  }
  Camera of(Camera camera) const {
    camera.eye = place(camera.eye);
    camera.target = place(camera.target);
    camera.up = turn(camera.up);
    return camera;
  }
};

Camera camera_on(const TestMesh& mesh, const char* view = "three_quarter") {
  return view_camera(view, bounds_of(mesh.position), {}, 1.0);
}

double mean_of(const Frame& frame, const char* layer) {
  const std::vector<float>& data = frame.find(layer)->data;
  return std::accumulate(data.begin(), data.end(), 0.0) / static_cast<double>(data.size());
}

/// Pixels in which two depth layers are not of the same surface: `scale` times as far, to 1e-5.
std::size_t differing(const std::vector<float>& z, const std::vector<float>& other, double scale) {
  std::size_t count = 0;
  for (std::size_t p = 0; p < z.size(); ++p) {
    const bool is_empty = z[p] > 1e9f, other_empty = other[p] > 1e9f;
    if (is_empty && other_empty) continue;
    count += is_empty != other_empty || std::abs(other[p] - scale * z[p]) > 1e-5 * scale * z[p];
  }
  return count;
}

// A quarter turn and a move, of everything: the same picture up to rounding at outlines, and noise.
TEST(Metamorphic, MovingTheWholeWorldChangesNoPicture) {
  const TestMesh mesh = bent(blob_figure(), 0.6f);
  const World world{[](const glm::dvec3& p) { return glm::dvec3(p.z + 3.0, p.y - 1.0, 7.0 - p.x); },
                    [](const glm::dvec3& d) { return glm::dvec3(d.z, d.y, -d.x); }};
  const Settings settings = settings_of(Mode::clay, 64);
  const Frame here = shoot(mesh, camera_on(mesh), settings);
  const Frame there = shoot(world.of(mesh), world.of(camera_on(mesh)), settings);
  EXPECT_LE(differing(here.find("Z")->data, there.find("Z")->data, 1.0), 96u * 96u / 500u);
  EXPECT_NEAR(mean_of(there, "R"), mean_of(here, "R"), 0.002 * mean_of(here, "R"));
}

// By a power of two nothing is rounded otherwise, and lights grow with the character.
TEST(Metamorphic, ScalingTheWorldByAPowerOfTwoGivesTheSameBits) {
  const TestMesh mesh = bent(blob_figure(), 0.6f);
  for (const double scale : {4.0, 1.0 / 64.0}) {
    const auto scaled = [scale](const glm::dvec3& p) { return scale * p; };
    const World world{scaled, [](const glm::dvec3& d) { return d; }};
    const Settings settings = settings_of(Mode::clay, 4);
    const Frame here = shoot(mesh, camera_on(mesh), settings);
    const Frame there = shoot(world.of(mesh), world.of(camera_on(mesh)), settings);
    EXPECT_EQ(here.find("R")->data, there.find("R")->data) << scale;
    EXPECT_EQ(here.find("N.X")->data, there.find("N.X")->data) << scale;
    EXPECT_EQ(differing(here.find("Z")->data, there.find("Z")->data, scale), 0u);
  }
}

TEST(Metamorphic, AMirroredWorldGivesTheMirroredPicture) {
  const TestMesh mesh = bent(blob_figure(), 0.6f);
  const auto mirror = [](const glm::dvec3& p) { return glm::dvec3(-p.x, p.y, p.z); };
  TestMesh mirrored = World{mirror, mirror}.of(mesh);
  auto topology = std::make_shared<MeshTopology>(*mirrored.topology);
  for (glm::uvec3& t : topology->triangle) std::swap(t.y, t.z);
  mirrored.topology = topology;
  Settings settings = settings_of(Mode::clay, 64);
  settings.environment = uniform_sky(0.7f);  // the studio's own lights are not symmetric
  const Camera camera = camera_on(mesh);
  const Frame here = shoot(mesh, camera, settings);
  const Frame there = shoot(mirrored, World{mirror, mirror}.of(camera), settings);
  std::vector<float> flipped;
  for (std::size_t y = 0; y < 96; ++y)
    for (std::size_t x = 0; x < 96; ++x) flipped.push_back(there.find("Z")->data[y * 96 + 95 - x]);
  EXPECT_LE(differing(here.find("Z")->data, flipped, 1.0), 96u * 96u / 500u);
  double left = 0.0, right = 0.0;
  for (std::size_t p = 0; p < 96 * 96; ++p) {
    const std::size_t x = p % 96;
    if (x < 48) left += here.find("R")->data[p * 4];
    if (x >= 48) right += there.find("R")->data[p * 4];
  }
  EXPECT_NEAR(left, right, 0.003 * left);
}

// A turntable turns the camera; turning the character the other way is the same.
TEST(Metamorphic, TurningTheCharacterIsTurningTheCameraBack) {
  const TestMesh mesh = bent(blob_figure(), 0.6f);
  const Settings settings = settings_of(Mode::clay, 64);
  const Bounds box = bounds_of(mesh.position);
  const std::vector<Camera> cameras = turntable(8, box, {}, 1.0);
  const glm::dvec3 middle = 0.5 * (box.low + box.high);
  const double angle = std::atan2(cameras[3].eye.x - middle.x, cameras[3].eye.z - middle.z) -
                       std::atan2(cameras[0].eye.x - middle.x, cameras[0].eye.z - middle.z);
  const auto turned = [angle](const glm::dvec3& d) {
    return glm::dvec3(std::cos(angle) * d.x - std::sin(angle) * d.z, d.y,
                      std::sin(angle) * d.x + std::cos(angle) * d.z);
  };
  World world{[&](const glm::dvec3& p) { return middle + turned(p - middle); }, turned};
  TestMesh other = world.of(mesh);
  // Lights and ground stand by the rest pose's box, which must be the same for both.
  const glm::vec3 low(-3, box.low.y, -3), high(3, box.high.y, 3);
  const auto with_box = [&](TestMesh with) {
    auto topology = std::make_shared<MeshTopology>(*with.topology);
    topology->rest_position[0] = glm::vec3(middle) + low;
    topology->rest_position[1] = glm::vec3(middle) + high;
    topology->rest_position[0].y = low.y, topology->rest_position[1].y = high.y;
    with.topology = topology;
    return with;
  };
  const Frame by_camera = shoot(with_box(mesh), cameras[3], settings);
  const Frame by_character = shoot(with_box(other), cameras[0], settings);
  EXPECT_LE(differing(by_camera.find("Z")->data, by_character.find("Z")->data, 1.0),
            96u * 96u / 300u);
  EXPECT_NEAR(mean_of(by_camera, "R"), mean_of(by_character, "R"), 0.002 * mean_of(by_camera, "R"));
}

TEST(Metamorphic, TheOrderOfTrianglesAndSharedCornersAreNotSeen) {
  const TestMesh mesh = bent(blob_figure(), 0.6f);
  const Settings settings = settings_of(Mode::clay, 4);
  const Frame plain = shoot(mesh, camera_on(mesh), settings);

  std::mt19937 rng(3);
  TestMesh shuffled = mesh;
  auto topology = std::make_shared<MeshTopology>(*mesh.topology);
  std::shuffle(topology->triangle.begin(), topology->triangle.end(), rng);
  shuffled.topology = topology;

  TestMesh apart = mesh;
  topology = std::make_shared<MeshTopology>(*mesh.topology);
  apart.position.clear(), apart.normal.clear();
  topology->triangle.clear(), topology->vertex_region.clear(), topology->rest_position.clear();
  for (const glm::uvec3& t : mesh.topology->triangle) {
    const auto first = static_cast<unsigned>(apart.position.size());
    topology->triangle.emplace_back(first, first + 1, first + 2);
    for (int corner = 0; corner < 3; ++corner) {
      apart.position.push_back(mesh.position[t[corner]]);
      apart.normal.push_back(mesh.normal[t[corner]]);
      topology->vertex_region.push_back(mesh.topology->vertex_region[t[corner]]);
      topology->rest_position.push_back(mesh.topology->rest_position[t[corner]]);
    }
  }
  apart.topology = topology;

  // Where a ray meets an edge exactly, the lower number wins, and its plane's last bit may differ.
  for (const TestMesh& other : {shuffled, apart}) {
    const Frame frame = shoot(other, camera_on(mesh), settings);
    for (const char* layer : {"R", "Z", "N.X", "CryptoObject00.r"}) {
      const std::vector<float>&is = frame.find(layer)->data, &should = plain.find(layer)->data;
      std::size_t others = 0;
      for (std::size_t i = 0; i < is.size(); ++i) others += is[i] != should[i];
      EXPECT_LE(others, is.size() / 2000) << layer;
    }
  }
}

TEST(Metamorphic, GeometryThatNoPathCanMeetIsNotSeen) {
  const TestMesh mesh = sphere({0, 1, 0}, 1.0f, 24);
  TestMesh filled = mesh;
  auto topology = std::make_shared<MeshTopology>(*mesh.topology);
  const auto first = static_cast<unsigned>(mesh.position.size());
  for (const glm::vec3 p : {glm::vec3(0.1f, 1, 0), glm::vec3(0, 1.1f, 0), glm::vec3(0, 1, 0.1f)}) {
    filled.position.push_back(p);
    filled.normal.emplace_back(0, 1, 0);
    topology->rest_position.push_back(p);
    topology->vertex_region.push_back(0);
  }
  topology->triangle.emplace_back(first, first + 1, first + 2);
  topology->triangle_material.push_back(0);
  filled.topology = topology;
  const Settings settings = settings_of(Mode::clay, 8);
  const Frame empty = shoot(mesh, camera_on(mesh), settings);
  const Frame full = shoot(filled, camera_on(mesh), settings);
  for (const Layer& layer : empty.layers)
    EXPECT_EQ(layer.data, full.find(layer.names[0])->data) << layer.names[0];
}

TEST(Metamorphic, AFlatTriangleMayBeCutInFour) {
  const TestMesh whole = square(1.0f);
  TestMesh cut = whole;
  auto topology = std::make_shared<MeshTopology>(*whole.topology);
  topology->triangle.clear();
  for (const glm::uvec3& t : whole.topology->triangle) {
    const auto m = static_cast<unsigned>(cut.position.size());
    for (int corner = 0; corner < 3; ++corner) {
      cut.position.push_back(0.5f *
                             (whole.position[t[corner]] + whole.position[t[(corner + 1) % 3]]));
      cut.normal.push_back(whole.normal[t[corner]]);
      topology->vertex_region.push_back(0);
    }
    for (const glm::uvec3& part : {glm::uvec3(t.x, m, m + 2), glm::uvec3(m, t.y, m + 1),
                                   glm::uvec3(m + 2, m + 1, t.z), glm::uvec3(m, m + 1, m + 2)})
      topology->triangle.push_back(part);
  }
  topology->triangle_material.assign(topology->triangle.size(), 0);
  topology->rest_position = cut.position;
  cut.topology = topology;
  const Settings settings = settings_of(Mode::clay, 8);
  const Camera camera = camera_on(whole, "front");
  const Frame one = shoot(whole, camera, settings), four = shoot(cut, camera, settings);
  EXPECT_EQ(differing(one.find("Z")->data, four.find("Z")->data, 1.0), 0u);
  EXPECT_NEAR(mean_of(four, "R"), mean_of(one, "R"), 1e-4 * mean_of(one, "R"));
}

// A ball with a hole under a sky of radiance 1, seen through the hole. Every place inside sees the
// hole under the same angle factor: its share h of the sphere. With reflectance r, j reflections
// more multiply by r (1 - h), so k of them after the first give r h (1 + q + ... + q^k), q = r (1 -
// h): the integrating sphere. Source: D. G. Goebel, "Generalized Integrating-Sphere Theory",
// Applied Optics 6(1), 1967.
TEST(WhiteFurnace, GivesABallWithAHoleWhatAnIntegratingSphereGives) {
  constexpr int kRings = 64;
  const TestMesh ball = sphere({0, 0, 0}, 1.0f, kRings);
  TestMesh bowl = ball;
  auto topology = std::make_shared<MeshTopology>(*ball.topology);
  topology->triangle.clear();
  // The fixture's pole is y; the hole is cut around +y, along a ring, and turned towards the
  // camera.
  const float brim = std::cos(std::numbers::pi_v<float> * 16.0f / kRings);  // 45 degrees
  for (const glm::uvec3& t : ball.topology->triangle) {
    const float middle = (ball.position[t.x].y + ball.position[t.y].y + ball.position[t.z].y) / 3;
    if (middle < brim) topology->triangle.push_back(t);
  }
  topology->triangle_material.assign(topology->triangle.size(), 0);
  for (auto* vectors : {&bowl.position, &bowl.normal})
    for (glm::vec3& v : *vectors) v = {v.x, -v.z, v.y};
  topology->rest_position = bowl.position;
  bowl.topology = topology;

  const double hole = 0.5 * (1.0 - brim), reflectance = 0.475;  // clay
  Camera camera;
  camera.eye = {0, 0, 6};
  camera.target = {0, 0, 0};
  camera.focal_mm = 400.0;  // sees the middle of the far wall
  Settings settings = settings_of(Mode::clay, 256, 32);
  settings.environment = uniform_sky(1.0f);
  settings.ground = false;
  for (const int bounces : {0, 1, 2, 6}) {
    settings.bounces = bounces;
    double expected = 0.0, again = reflectance * hole;
    for (int k = 0; k <= bounces; ++k, again *= reflectance * (1.0 - hole)) expected += again;
    const std::vector<float> picture = shoot(bowl, camera, settings).find("R")->data;
    double mean = 0.0;
    for (std::size_t i = 1; i < picture.size(); i += 4) mean += picture[i] / (32.0 * 32.0);
    // Facets of 64 rings lie inside the ball and leave the hole a little larger.
    EXPECT_NEAR(mean, expected, 0.015 * expected) << bounces;
  }
}

// Many short looks at what one number answers: their mean is that number within four standard
// errors, of 1000 seeds.
TEST(Convergence, OfAThousandSeedsIsTowardsTheAnalyticMean) {
  const TestMesh mesh = sphere({0, 0, 0}, 1.0f, 48);
  Scene scene(mesh.topology);
  scene.set_pose(mesh.pose());
  Settings settings = settings_of(Mode::clay, 1, 8);
  settings.environment = uniform_sky(1.0f);
  settings.ground = false;
  Camera camera;
  camera.eye = {0, 0, 4};
  camera.target = {0, 0, 0};
  camera.focal_mm = 300.0;
  double sum = 0.0, squares = 0.0;
  constexpr int kSeeds = 1000;
  for (int seed = 0; seed < kSeeds; ++seed) {
    settings.seed = static_cast<std::uint32_t>(seed);
    const double pixel = scene.render(camera, settings).find("R")->data[(3 * 8 + 4) * 4];
    sum += pixel, squares += pixel * pixel;
  }
  const double mean = sum / kSeeds, variance = squares / kSeeds - mean * mean;
  EXPECT_GT(variance, 0.0);
  EXPECT_NEAR(mean, 0.475, 4.0 * std::sqrt(variance / kSeeds));
}

TEST(Visibility, IsTheSameFromBothEnds) {
  const TestMesh mesh = bent(blob_figure(), 0.6f);
  const RayScene scene(mesh.topology->triangle, mesh.position);
  const Bounds box = bounds_of(mesh.position);
  std::mt19937 rng(4);
  const auto anywhere = [&] {
    glm::dvec3 p;
    for (int axis = 0; axis < 3; ++axis)
      p[axis] = box.low[axis] + (box.high[axis] - box.low[axis]) * (rng() >> 8) * 0x1p-24;
    return glm::vec3(p);
  };
  const auto there = std::make_unique<RayBatch>(), back = std::make_unique<RayBatch>();
  std::vector<std::uint8_t> blocked_there(RayBatch::kCapacity), blocked_back(RayBatch::kCapacity);
  std::size_t blocked = 0, different = 0, count = 0;
  for (int batch = 0; batch < 40; ++batch, count += RayBatch::kCapacity) {
    for (std::size_t i = 0; i < RayBatch::kCapacity; i += 8) {
      Vec8 a, b;
      for (unsigned lane = 0; lane < 8; ++lane)
        a.set_lane(lane, anywhere()), b.set_lane(lane, anywhere());
      there->set_packet(i, a, b - a, splat(1.0f));
      back->set_packet(i, b, a - b, splat(1.0f));
    }
    scene.occluded(*there, RayBatch::kCapacity, blocked_there.data());
    scene.occluded(*back, RayBatch::kCapacity, blocked_back.data());
    for (std::size_t i = 0; i < RayBatch::kCapacity; ++i) {
      blocked += blocked_there[i];
      different += blocked_there[i] != blocked_back[i];
    }
  }
  EXPECT_GT(blocked, count / 20);
  // Rounding decides for a ray that grazes an edge.
  EXPECT_LE(different, count / 20'000) << "of " << count;
}

// From a convex body every ray that leaves the surface is free, or the surface shadows itself.
TEST(Visibility, OfASurfaceIsNeverBlockedByItself) {
  for (const float radius : {0.01f, 1.0f, 1000.0f}) {
    const TestMesh mesh = sphere({3 * radius, radius, -5 * radius}, radius, 48);
    const RayScene rays(mesh.topology->triangle, mesh.position);
    const Bounds box = bounds_of(mesh.position);
    SceneView view{mesh.topology.get(), &rays, mesh.pose(), {}, 0.0f, 0.0f, {}};
    view.rest_radius = static_cast<float>(0.5 * glm::length(box.high - box.low));
    std::mt19937 rng(5);
    const auto unit = [&] {
      Float8 v{};
      for (int lane = 0; lane < 8; ++lane) v[lane] = static_cast<float>(rng() >> 8) * 0x1p-24f;
      return v;
    };
    const auto batch = std::make_unique<RayBatch>();
    std::vector<std::uint8_t> blocked(RayBatch::kCapacity);
    std::size_t hits = 0;
    for (int round = 0; round < 20; ++round) {
      for (std::size_t i = 0; i < RayBatch::kCapacity; i += 8) {
        Int8 triangle;
        Vec8 from, towards;
        for (unsigned lane = 0; lane < 8; ++lane) {
          triangle[lane] = static_cast<int>(rng() % mesh.topology->triangle.size());
          const glm::uvec3& t = mesh.topology->triangle[triangle[lane]];
          glm::vec3 weight(0.01f + unit()[0], 0.01f + unit()[0], 0.01f + unit()[0]);
          weight /= weight.x + weight.y + weight.z;
          const glm::vec3 p = mesh.position[t.x] * weight.x + mesh.position[t.y] * weight.y +
                              mesh.position[t.z] * weight.z;
          from.set_lane(lane, p + (p - glm::vec3(3 * radius, radius, -5 * radius)) * 2.0f);
          towards.set_lane(lane, p);
        }
        const Surface8 at = surface_at(view, triangle, from, normalize(towards - from));
        const Point8 random{unit(), unit()};
        batch->set_packet(i, at.launch, sample_cosine(at.geometric, random), splat(1e30f));
      }
      rays.occluded(*batch, RayBatch::kCapacity, blocked.data());
      hits += static_cast<std::size_t>(std::count(blocked.begin(), blocked.end(), 1));
    }
    EXPECT_EQ(hits, 0u) << "radius " << radius;
  }
}

TEST(Layers, HoldAlphaBetweenNothingAndAllAndNormalsOfLengthOne) {
  const TestMesh mesh = bent(blob_figure(), 0.6f);
  for (const Mode mode : {Mode::beauty, Mode::clay, Mode::ao, Mode::matcap, Mode::wireframe,
                          Mode::xray, Mode::contour, Mode::primary}) {
    for (const bool transparent : {false, true}) {
      Settings settings = settings_of(mode, 8, 48);
      settings.transparent = transparent;
      const Frame frame = shoot(mesh, camera_on(mesh), settings);
      const std::vector<float>& color = frame.find("R")->data;
      for (std::size_t p = 0; p < color.size(); p += 4) {
        ASSERT_TRUE(color[p + 3] >= 0.0f && color[p + 3] <= 1.0f + 1e-6f) << color[p + 3];
        for (std::size_t c = 0; c < 3; ++c) ASSERT_GE(color[p + c], 0.0f);
      }
      const std::vector<float>& normal = frame.find("N.X")->data;
      for (std::size_t p = 0; p < normal.size(); p += 3) {
        const float length = std::hypot(normal[p], normal[p + 1], normal[p + 2]);
        ASSERT_TRUE(length == 0.0f || std::abs(length - 1.0f) < 1e-5f) << length;
      }
    }
  }
}

}  // namespace
}  // namespace backbend::render
