#include "render/trace/denoiser.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>
#include <random>

#include "render/image/exr.h"
#include "render/image/picture.h"
#include "render/trace/cameras.h"
#include "render/trace/frame_layers.h"
#include "tests/render/mesh_fixture.h"

namespace backbend::render {
namespace {

constexpr int kWidth = 61, kHeight = 40;  // no multiple of a packet

/// A picture in two noisy halves over surfaces whose albedo alone tells them apart.
struct Noisy {
  std::vector<float> truth, a, b, albedo, normal, depth;
  Noisy(float noise, const std::function<float(int x, int y)>& light,
        const std::function<float(int x, int y)>& reflectance) {
    std::mt19937 rng(3);
    std::uniform_real_distribution<float> spread(-noise, noise);
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        for (int c = 0; c < 3; ++c) {
          truth.push_back(light(x, y));
          a.push_back(truth.back() + spread(rng));
          b.push_back(truth.back() + spread(rng));
          albedo.push_back(reflectance(x, y));
          normal.push_back(c == 2 ? 1.0f : 0.0f);
        }
        depth.push_back(2.0f);
      }
    }
  }
  Denoised denoised() const { return denoise({kWidth, kHeight, a, b, albedo, normal, depth}); }
};

double mean_square(const std::vector<float>& a, const std::vector<float>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return sum / static_cast<double>(a.size());
}

TEST(Denoiser, LeavesAPictureWithoutNoiseAsItIs) {
  const Noisy stripes(
      0.0f, [](int x, int y) { return (x / 3 + y / 4) % 2 == 0 ? 0.3f : 0.4f; },
      [](int, int) { return 0.5f; });
  const Denoised clean = stripes.denoised();
  for (std::size_t i = 0; i < clean.color.size(); ++i)
    ASSERT_NEAR(clean.color[i], stripes.truth[i], 1e-6) << i;
  for (const float error : clean.error) ASSERT_LT(error, 1e-6f);
}

// A mean over 121 equal neighbours would leave 1/11 of the noise; weights that noise itself makes
// uneven leave more. The error it claims must be about the error it makes.
TEST(Denoiser, TakesNoiseAwayAndKnowsHowMuchIsLeft) {
  const Noisy flat(
      0.1f, [](int x, int) { return 0.4f + 0.001f * static_cast<float>(x); },
      [](int, int) { return 0.5f; });
  const Denoised clean = flat.denoised();
  std::vector<float> mean(flat.a.size());
  for (std::size_t i = 0; i < mean.size(); ++i) mean[i] = 0.5f * (flat.a[i] + flat.b[i]);
  const double before = std::sqrt(mean_square(mean, flat.truth));
  const double after = std::sqrt(mean_square(clean.color, flat.truth));
  EXPECT_LT(after, before / 5.0);
  double claimed = 0.0;
  for (const float error : clean.error) claimed += error * error / clean.error.size();
  EXPECT_LT(std::sqrt(claimed), 1.6 * after);
  EXPECT_GT(std::sqrt(claimed), after / 1.6);
}

TEST(Denoiser, KeepsAnEdgeThatOnlyTheAlbedoShows) {
  const auto side = [](int x, int) { return x < 30 ? 0.45f : 0.55f; };
  const Noisy edge(0.3f, side, [](int x, int) { return x < 30 ? 0.2f : 0.8f; });
  const Denoised clean = edge.denoised();
  for (const int x : {28, 29, 30, 31}) {
    double mean = 0.0;
    for (int y = 0; y < kHeight; ++y)
      mean += clean.color[(static_cast<std::size_t>(y) * kWidth + x) * 3] / kHeight;
    EXPECT_NEAR(mean, side(x, 0), 0.025) << x;
  }
}

struct Shot {
  TestMesh mesh = sphere({0, 1, 0}, 1.0f, 32);
  Scene scene{mesh.topology};
  Settings settings;
  Shot() {
    scene.set_pose(mesh.pose());
    settings.width = 96;
    settings.height = 64;
  }
  Frame taken() const {
    return scene.render(view_camera("front", bounds_of(mesh.position), {}, 1.5), settings);
  }
};

TEST(Denoiser, AddsALayerForPeopleAndTouchesNoOther) {
  Shot shot;
  const Frame plain = shot.taken();
  shot.settings.denoise = true;
  const Frame both = shot.taken();
  for (const Layer& layer : plain.layers) {
    const Layer* same = both.find(layer.names.front());
    ASSERT_NE(same, nullptr) << layer.names.front();
    EXPECT_EQ(same->data, layer.data) << layer.names.front();
  }
  ASSERT_NE(both.find("denoised.R"), nullptr);
  ASSERT_NE(both.find("denoisedError"), nullptr);
  EXPECT_NE(picture_from(both).rgba, picture_from(plain).rgba);
  // Modes without sampled light have nothing to clean.
  shot.settings.mode = Mode::primary;
  EXPECT_EQ(shot.taken().find("denoised.R"), nullptr);
}

TEST(Denoiser, GivesTheSameBytesForAnyNumberOfThreads) {
  Shot shot;
  shot.settings.denoise = true;
  shot.settings.noise = 0.02;
  shot.settings.samples = 64;
  shot.settings.all_layers = true;
  shot.settings.threads = 1;
  const auto one = encode_exr(shot.taken());
  for (const int threads : {2, 5, 16}) {
    shot.settings.threads = threads;
    EXPECT_EQ(encode_exr(shot.taken()), one) << threads;
  }
}

TEST(AdaptiveSampling, SpendsItsSamplesWhereTheNoiseIs) {
  Shot shot;
  shot.settings.noise = 0.01;
  shot.settings.samples = 256;
  shot.settings.all_layers = true;
  const Frame frame = shot.taken();
  const std::vector<float>& count = frame.find("sampleCount")->data;
  EXPECT_EQ(count.front(), 8.0f);  // the backdrop has no noise
  float most = 0.0f;
  for (const float samples : count) {
    most = std::max(most, samples);
    ASSERT_TRUE(std::has_single_bit(static_cast<unsigned>(samples))) << samples;
  }
  EXPECT_GT(most, 16.0f);
  // Whatever its pixels' number of samples, the figure's inside is covered wholly.
  const std::vector<float>& matte = frame.find("CryptoAsset00.r")->data;
  const std::size_t middle = 32 * 96 + 48;
  EXPECT_EQ(matte[middle * 4 + 1], 1.0f);
}

TEST(AdaptiveSampling, EndsNoTileBeforeTheLeastSamples) {
  Shot shot;
  shot.settings.noise = 0.02;
  shot.settings.samples = 8;
  shot.settings.all_layers = true;
  for (const int least : {4, 8}) {
    shot.settings.least_samples = least;
    const Frame frame = shot.taken();
    const std::vector<float>& count = frame.find("sampleCount")->data;
    EXPECT_EQ(count.front(), static_cast<float>(least));  // the backdrop has no noise
    EXPECT_EQ(*std::max_element(count.begin(), count.end()), 8.0f) << least;
  }
}

// What was asked for is met: against a picture of another seed with many times the samples.
TEST(AdaptiveSampling, MeetsTheErrorItWasAskedFor) {
  Shot shot;
  shot.settings.samples = 1024;
  shot.settings.seed = 7;
  const Frame truth = shot.taken();
  shot.settings.seed = 0;
  shot.settings.noise = 0.02;
  const Frame frame = shot.taken();
  const std::vector<float>&is = frame.find("R")->data, &should = truth.find("R")->data;
  int blocks = 0, missed = 0;
  for (int y = 0; y < 64; y += 8) {
    for (int x = 0; x < 96; x += 8, ++blocks) {
      double error = 0.0;
      for (int i = 0; i < 64; ++i) {
        const std::size_t pixel = static_cast<std::size_t>(y + i / 8) * 96 + x + i % 8;
        double difference = 0.0, light = 0.0;
        for (int c = 0; c < 3; ++c) {
          difference += std::abs(is[pixel * 4 + c] - should[pixel * 4 + c]);
          light += should[pixel * 4 + c];
        }
        error += difference / std::sqrt(std::max(light, 0.01)) / 64.0;
      }
      // The estimate is one draw of a block of 64 pixels.
      missed += error > 1.3 * 0.02 ? 1 : 0;
    }
  }
  EXPECT_LE(missed, blocks / 20);
}

// The key light stands 52 degrees to the camera's left; turned by twice that to the right it lights
// the other side.
TEST(LightTurn, BringsTheKeyLightToTheOtherSideAndBack) {
  Shot shot;
  shot.settings.samples = 64;
  const auto lit_left = [&](double turn_deg) {
    shot.settings.light_turn_deg = turn_deg;
    const Frame frame = shot.taken();
    const std::vector<float>& light = frame.find("R")->data;
    const std::vector<float>& matte = frame.find("CryptoAsset00.r")->data;
    double sum = 0.0;
    for (std::size_t p = 0; p < light.size() / 4; ++p)
      if (matte[p * 4 + 1] == 1.0f) sum += p % 96 < 48 ? light[p * 4] : -light[p * 4];
    return sum;
  };
  const double before = lit_left(0.0);
  EXPECT_GT(before, 10.0);
  EXPECT_LT(lit_left(-104.0), -10.0);
  EXPECT_NEAR(lit_left(360.0), before, 0.01 * before);
}

}  // namespace
}  // namespace backbend::render
