#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <random>

#include "render/image/heat_map.h"
#include "render/trace/bsdf.h"
#include "render/trace/cameras.h"
#include "render/trace/environment_map.h"
#include "render/trace/scene_view.h"
#include "render/trace/surface.h"
#include "tests/render/mesh_fixture.h"

namespace backbend::render {
namespace {

std::shared_ptr<const Texture> uniform_sky() {
  auto sky = std::make_shared<Texture>();
  sky->width = 16;
  sky->height = 8;
  sky->texel.assign(128, glm::vec4(1.0f));
  return sky;
}

// Mean beauty over the pixels that the figure covers wholly.
double mean_on_figure(const Frame& frame) {
  const auto& beauty = frame.find("R")->data;
  const auto& matte = frame.find("CryptoAsset00.r")->data;
  double sum = 0.0;
  int count = 0;
  for (std::size_t p = 0; p < beauty.size() / 4; ++p) {
    if (matte[p * 4 + 1] < 1.0f) continue;
    sum += beauty[p * 4 + 1];
    ++count;
  }
  EXPECT_GT(count, 500);
  return sum / count;
}

Frame furnace(Material material, Mode mode) {
  const TestMesh mesh = sphere({0, 0, 0}, 1.0f, 48);
  mesh.topology->materials[0] = material;
  Scene scene(mesh.topology);
  scene.set_pose(mesh.pose());
  Settings settings;
  settings.width = settings.height = 48;
  settings.samples = 64;
  settings.mode = mode;
  settings.ground = false;
  settings.environment = uniform_sky();
  return scene.render(view_camera("front", bounds_of(mesh.position), {}, 1.0), settings);
}

// Under a sky of 1 a convex body of reflectance r sends r everywhere. The mesh is convex, so one
// bounce is all there is; what is left is noise, 2000 pixels of 64 samples.
TEST(WhiteFurnace, GivesALambertBallItsOwnReflectance) {
  EXPECT_NEAR(mean_on_figure(furnace({}, Mode::clay)), 0.475, 0.475 * 0.005);
}

TEST(WhiteFurnace, MakesAWhiteMirrorDisappear) {
  Material mirror;
  mirror.base_color = glm::vec3(1.0f);
  mirror.metallic = 1.0f;
  mirror.roughness = 0.1f;
  EXPECT_NEAR(mean_on_figure(furnace(mirror, Mode::beauty)), 1.0, 0.01);
}

TEST(WhiteFurnace, NeverGivesBackMoreThanCameIn) {
  for (const float metallic : {0.0f, 1.0f}) {
    for (const float roughness : {0.2f, 0.5f, 1.0f}) {
      Material white;
      white.base_color = glm::vec3(1.0f);
      white.metallic = metallic;
      white.roughness = roughness;
      const double sent = mean_on_figure(furnace(white, Mode::beauty));
      // glTF's mixture of coat and base is over by 2 % for white plastic; see bsdf.cpp.
      EXPECT_LT(sent, metallic > 0.0f ? 1.005 : 1.025) << metallic << ' ' << roughness;
      // A rough mirror loses what would bounce twice between its facets: about 6/10 at alpha 1.
      EXPECT_GT(sent, metallic > 0.0f && roughness == 1.0f ? 0.35 : 0.85)
          << metallic << ' ' << roughness;
    }
  }
}

TEST(Bsdf, IsSampledAsItsDensitySays) {
  const Vec8 n = splat(glm::normalize(glm::vec3(0.3f, -0.5f, 0.8f)));
  const Vec8 out = normalize(n + frame_around(n).tangent * splat(0.8f));
  const Bsdf8 bsdf{splat(glm::vec3(0.4f)), splat(glm::vec3(0.3f)), splat(0.35f), true};
  std::mt19937 rng(1);
  std::uniform_real_distribution<float> uniform(0.0f, 1.0f);
  const auto random = [&] {
    Float8 v{};
    for (int lane = 0; lane < 8; ++lane) v[lane] = uniform(rng);
    return v;
  };
  // Integral of value by BSDF sampling against the same by uniform sampling of the half sphere.
  double by_bsdf = 0.0, by_uniform = 0.0, density = 0.0;
  const int packets = 25'000, count = packets * 8;
  for (int i = 0; i < packets; ++i) {
    const BsdfSample8 s = sample_bsdf(bsdf, n, out, {random(), random()}, random());
    const Float8 z = random();
    const SineCosine8 angle = sincos_turns(random());
    const Float8 r = sqrt(1.0f - z * z);
    const Frame8 f = frame_around(n);
    const Vec8 in = f.tangent * (r * angle.cosine) + f.bitangent * (r * angle.sine) + n * z;
    const BsdfValue8 v = eval_bsdf(bsdf, n, out, in);
    for (int lane = 0; lane < 8; ++lane) {
      by_bsdf += s.weight.x[lane] / count;
      by_uniform += v.value.x[lane] * 2.0 * M_PI / count;
      density += v.pdf[lane] * 2.0 * M_PI / count;
    }
  }
  EXPECT_NEAR(by_bsdf, by_uniform, 0.01 * by_uniform);
  EXPECT_LT(density, 1.01);  // some half vectors lead below the surface
  EXPECT_GT(density, 0.95);
}

TEST(Environment, IsSampledInProportionToItsLight) {
  Texture picture{8, 4, {}};
  for (int i = 0; i < 32; ++i) picture.texel.push_back(glm::vec4(i == 13 ? 50.0f : 0.1f * (i % 5)));
  const EnvironmentMap map(picture);
  std::mt19937 rng(2);
  std::uniform_real_distribution<float> uniform(0.0f, 1.0f);
  double light = 0.0, expected = 0.0;
  const int count = 100'000;
  for (int i = 0; i < count; ++i) {
    const auto s = map.sample({uniform(rng), uniform(rng)});
    ASSERT_NEAR(glm::length(s.direction), 1.0f, 1e-5f);
    EXPECT_EQ(map.radiance(s.direction), s.radiance);
    light += s.radiance.x / s.pdf / count;
    const float y = 2.0f * uniform(rng) - 1.0f, a = 2.0f * static_cast<float>(M_PI) * uniform(rng);
    const float r = std::sqrt(1.0f - y * y);
    expected += map.radiance({r * std::cos(a), y, r * std::sin(a)}).x * 4.0 * M_PI / count;
  }
  EXPECT_NEAR(light, expected, 0.05 * expected);
}

// A picture turned by three of its columns shows in every direction what it showed three columns
// before.
TEST(Environment, TurnsWithItsSamples) {
  Texture picture{8, 4, {}};
  for (int i = 0; i < 32; ++i) picture.texel.push_back(glm::vec4(1.0f + static_cast<float>(i)));
  const double step = 2.0 * M_PI / 8.0;
  const EnvironmentMap map(picture), turned(picture, 3.0 * step);
  for (int column = 0; column < 8; ++column) {
    const double from = (column + 0.5) * step, to = from + 3.0 * step;
    EXPECT_EQ(turned.radiance({std::sin(to), 0.0, std::cos(to)}),
              map.radiance({std::sin(from), 0.0, std::cos(from)}))
        << column;
  }
  for (int i = 0; i < 64; ++i) {
    const auto s = turned.sample(
        {(static_cast<float>(i % 8) + 0.4f) / 8.0f, (static_cast<float>(i) + 0.5f) / 64.0f});
    EXPECT_EQ(turned.radiance(s.direction), s.radiance) << i;
    EXPECT_NEAR(turned.pdf(s.direction), s.pdf, 1e-6f) << i;
  }
}

TEST(Environment, RefusesPicturesWithoutLight) {
  EXPECT_THROW(EnvironmentMap(Texture{}), RenderError);
  EXPECT_THROW(EnvironmentMap({2, 1, {glm::vec4(0.0f), glm::vec4(0.0f)}}), RenderError);
  EXPECT_THROW(EnvironmentMap({2, 1, {glm::vec4(1.0f), glm::vec4(std::nanf(""))}}), RenderError);
  EXPECT_THROW(EnvironmentMap({2, 1, {glm::vec4(1.0f), glm::vec4(-1.0f)}}), RenderError);
}

// A picture of one texel leans every normal alike: by red towards its right, by green towards its
// top, as glTF has it, however the picture lies on the surface and from whichever side it is seen.
TEST(NormalPicture, LeansToItsRightByRedAndToItsTopByGreen) {
  struct Lie {
    const char* what;
    glm::vec2 (*uv)(const glm::vec3& at);  // v grows towards the picture's bottom
    glm::vec2 right, top;                  // of the picture, in the square's plane
  };
  const Lie lies[] = {
      {"upright", [](const glm::vec3& p) { return glm::vec2(p.x, -p.y); }, {1, 0}, {0, 1}},
      {"mirrored", [](const glm::vec3& p) { return glm::vec2(-p.x, -p.y); }, {-1, 0}, {0, 1}},
      {"upside down", [](const glm::vec3& p) { return glm::vec2(-p.x, p.y); }, {-1, 0}, {0, -1}},
      {"a quarter turned", [](const glm::vec3& p) { return glm::vec2(p.y, p.x); }, {0, 1}, {-1, 0}},
  };
  const glm::vec3 leaning(0.48f, 0.36f, 0.8f);  // of unit length
  for (const Lie& lie : lies) {
    const TestMesh mesh = square(2.0f);
    MeshTopology& topology = *mesh.topology;
    topology.textures = {{1, 1, {glm::vec4(0.5f * leaning + 0.5f, 1.0f)}}};
    topology.materials[0].normal_texture = 0;
    for (const glm::vec3& p : mesh.position) topology.uv.push_back(lie.uv(p));
    const SceneView scene{&topology, nullptr, mesh.pose(), {}, 1.0f, -1.0f};
    for (const float side : {1.0f, -1.0f}) {
      const Vec8 eye = splat(glm::vec3(0.2f, -0.1f, 3.0f * side));
      Surface8 surface = surface_at(scene, splat(0), eye, splat(glm::vec3(0.0f, 0.0f, -side)));
      material_at(scene, surface, 0xffu);
      const glm::vec2 in_plane = lie.right * leaning.x + lie.top * leaning.y;
      const glm::vec3 expected(in_plane, side * leaning.z), found = surface.shading.lane(3);
      EXPECT_NEAR(glm::length(found - expected), 0.0f, 1e-6f)
          << lie.what << " from " << side << ": " << found.x << " " << found.y << " " << found.z;
    }
  }
}

TEST(HeatMap, GetsLighterAllTheWay) {
  float last = -1.0f;
  for (int i = 0; i <= 100; ++i) {
    const glm::vec3 c = heat_color(static_cast<float>(i) / 100.0f);
    const float light = 0.2126f * c.x + 0.7152f * c.y + 0.0722f * c.z;
    EXPECT_GT(light, last) << i;
    EXPECT_LE(std::max({c.x, c.y, c.z}), 1.0f) << i;
    last = light;
  }
  EXPECT_EQ(heat_color(-3.0f), heat_color(0.0f));
  EXPECT_EQ(heat_color(3.0f), heat_color(1.0f));
}

// Full loss of the long- or middle-wave cones leaves the sum of red and green, and blue. Steps of a
// tenth stay apart in these, so nothing is told by red against green alone.
TEST(HeatMap, KeepsItsStepsApartWithoutRedAgainstGreen) {
  for (int i = 0; i < 10; ++i) {
    const glm::vec3 a = heat_color(static_cast<float>(i) / 10.0f);
    const glm::vec3 b = heat_color(static_cast<float>(i + 1) / 10.0f);
    const float yellow_a = 0.3f * a.x + 0.7f * a.y, yellow_b = 0.3f * b.x + 0.7f * b.y;
    EXPECT_GT(std::cbrt(yellow_b) - std::cbrt(yellow_a), 0.03f) << i;
  }
}

}  // namespace
}  // namespace backbend::render
