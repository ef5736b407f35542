#include "render/trace/sampler.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <utility>
#include <vector>

#include "render/trace/pixel_filter.h"

namespace backbend::render {
namespace {

// The parts of a packet of 4 x 2 pixels.
std::vector<std::uint32_t> packet_at(const Sampler& sampler, int x, int y) {
  std::vector<std::uint32_t> pixels(sampler.words_per_packet());
  sampler.place(splat(x) + Int8{0, 1, 2, 3, 0, 1, 2, 3}, splat(y) + Int8{0, 0, 0, 0, 1, 1, 1, 1},
                pixels.data());
  return pixels;
}

// Whether every elementary interval of area 1/count holds one of `count` points.
bool is_net(const std::vector<std::pair<float, float>>& points) {
  const int count = static_cast<int>(points.size());
  for (int columns = 1; columns <= count; columns *= 2) {
    const int rows = count / columns;
    std::set<int> cells;
    for (const auto& [x, y] : points)
      cells.insert(static_cast<int>(x * static_cast<float>(columns)) * rows +
                   static_cast<int>(y * static_cast<float>(rows)));
    if (cells.size() != points.size()) return false;
  }
  return true;
}

TEST(Sampler, PutsOnePointOfAPixelIntoEveryElementaryInterval) {
  const int count = 64;
  const Sampler sampler(count, 4, 17);
  const auto pixels = packet_at(sampler, 12, 34);
  for (int pair = 0; pair < 4; ++pair) {
    for (unsigned lane = 0; lane < 8; ++lane) {
      std::vector<std::pair<float, float>> points;
      for (int s = 0; s < count; ++s) {
        const Point8 p = sampler.points(s, pair, pixels.data());
        ASSERT_TRUE(p.x[lane] >= 0.0f && p.x[lane] < 1.0f && p.y[lane] >= 0.0f && p.y[lane] < 1.0f);
        points.emplace_back(p.x[lane], p.y[lane]);
        const std::size_t so_far = points.size();
        if ((so_far & (so_far - 1)) == 0) {
          EXPECT_TRUE(is_net(points)) << "pair " << pair << " lane " << lane << " of " << so_far;
        }
      }
    }
  }
}

// What makes the noise fine-grained: a block of 2 x 2 pixels is spread like one pixel with four
// times the samples.
TEST(Sampler, SpreadsTheSamplesOfFourNeighboursTogether) {
  const Sampler sampler(16, 3, 5);
  const auto pixels = packet_at(sampler, 20, 40);
  for (int pair = 0; pair < 3; ++pair) {
    std::vector<std::pair<float, float>> points;
    for (int s = 0; s < 16; ++s) {
      const Point8 p = sampler.points(s, pair, pixels.data());
      for (const unsigned lane : {0u, 1u, 4u, 5u}) points.emplace_back(p.x[lane], p.y[lane]);
    }
    EXPECT_TRUE(is_net(points)) << "pair " << pair;
  }
}

TEST(Sampler, GivesARayThatLeftItsPacketThePointsOfItsPixel) {
  const Sampler sampler(16, 3, 99);
  auto pixels = packet_at(sampler, 100, 50);
  const auto second = packet_at(sampler, 104, 50);
  pixels.insert(pixels.end(), second.begin(), second.end());
  const Int8 pixel{3, 11, 7, 0, 15, 2, 8, 4}, sample{0, 15, 3, 7, 7, 1, 2, 8};
  for (int pair = 0; pair < 3; ++pair) {
    const Point8 p = sampler.points(sample, pair, pixels.data(), pixel);
    for (int i = 0; i < 8; ++i) {
      const Point8 home = sampler.points(sample[i], pair,
                                         pixels.data() + pixel[i] / 8 * sampler.words_per_packet());
      EXPECT_EQ(p.x[i], home.x[pixel[i] % 8]);
      EXPECT_EQ(p.y[i], home.y[pixel[i] % 8]);
    }
  }
}

TEST(Sampler, DecorrelatesDimensions) {
  const int count = 256;
  const Sampler sampler(count, 3, 5);
  // 12 times the covariance of uniform numbers is their correlation. Averaged over 64 places, 256
  // independent points would leave a standard deviation of 1/128.
  double correlation = 0.0;
  for (int place = 0; place < 64; ++place) {
    const auto pixels = packet_at(sampler, place % 8 * 4, place / 8 * 2);
    for (int s = 0; s < count; ++s) {
      const Point8 a = sampler.points(s, 1, pixels.data()), b = sampler.points(s, 2, pixels.data());
      correlation += (a.x[2] - 0.5) * (b.x[2] - 0.5) * 12.0 / count / 64;
    }
  }
  EXPECT_LT(std::abs(correlation), 0.04);
}

TEST(Lanes, GiveSineAndCosineOfTheWholeTurn) {
  for (int i = 0; i <= 1000; ++i) {
    const double turns = i / 1000.0;
    const SineCosine8 angle = sincos_turns(splat(static_cast<float>(turns)));
    EXPECT_NEAR(angle.sine[0], std::sin(2.0 * M_PI * turns), 6e-7) << turns;
    EXPECT_NEAR(angle.cosine[5], std::cos(2.0 * M_PI * turns), 6e-7) << turns;
  }
}

TEST(Lanes, MoveToTheFrontInTheirOrder) {
  const Int8 mask{0, -1, 0, 0, -1, -1, 0, -1};
  const Compress kept(mask);
  EXPECT_EQ(kept.count(), 4u);
  float out[8];
  kept.write(out, Float8{10, 11, 12, 13, 14, 15, 16, 17});
  EXPECT_EQ(out[0], 11.0f);
  EXPECT_EQ(out[1], 14.0f);
  EXPECT_EQ(out[2], 15.0f);
  EXPECT_EQ(out[3], 17.0f);
}

TEST(PixelFilter, SpreadsSamplesEvenlyAroundThePixel) {
  const PixelFilter filter;
  double mean = 0.0, square = 0.0;
  float last = -2.0f;
  for (int i = 0; i < 4096; ++i) {
    const float x = filter.offset(splat((static_cast<float>(i) + 0.5f) / 4096.0f))[i % 8];
    EXPECT_GT(x, last);
    EXPECT_LE(std::abs(x), 1.0f);
    last = x;
    mean += x / 4096.0;
    square += x * x / 4096.0;
  }
  EXPECT_NEAR(mean, 0.0, 1e-6);
  // Variance of the Blackman-Harris window on [-1, 1]: 1/3 + sum of 4 a_k cos(k pi) / (a_0 (k
  // pi)^2) / 2.
  double expected = 1.0 / 3.0;
  const double a[4] = {0.35875, 0.48829, 0.14128, 0.01168};
  for (int k = 1; k < 4; ++k)
    expected += 2.0 * a[k] * std::cos(k * M_PI) / (a[0] * (k * M_PI) * (k * M_PI));
  EXPECT_NEAR(square, expected, 1e-3);
}

}  // namespace
}  // namespace backbend::render
