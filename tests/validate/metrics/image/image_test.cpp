#include "validate/metrics/image/image.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <random>

#include "validate/metrics/math/rotation.h"

namespace backbend::validate {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

Mask rectangle(int width, int height, int x0, int y0, int x1, int y1) {
  Mask mask{width, height, std::vector<std::uint8_t>(static_cast<std::size_t>(width) * height, 0)};
  for (int y = y0; y < y1; ++y)
    for (int x = x0; x < x1; ++x) mask.inside[static_cast<std::size_t>(y) * width + x] = 1;
  return mask;
}

TEST(SquaredDistance, IsThatOfBruteForceForEveryPixel) {
  std::mt19937 rng(1);
  for (int picture = 0; picture < 40; ++picture) {
    const int width = 1 + static_cast<int>(rng() % 23), height = 1 + static_cast<int>(rng() % 17);
    Mask mask{width, height, {}};
    const unsigned rarity = 2 + rng() % 60;
    for (int i = 0; i < width * height; ++i) mask.inside.push_back(rng() % rarity == 0);
    const std::vector<double> fast = squared_distance(mask);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        double slow = kInfinity;
        for (int v = 0; v < height; ++v)
          for (int u = 0; u < width; ++u)
            if (mask.inside[static_cast<std::size_t>(v) * width + u])
              slow = std::min(slow, static_cast<double>((x - u) * (x - u) + (y - v) * (y - v)));
        EXPECT_EQ(fast[static_cast<std::size_t>(y) * width + x], slow);
      }
  }
}

TEST(OutlineDistance, IsTheShiftOfAShiftedSquare) {
  const Mask a = rectangle(60, 50, 10, 10, 30, 30), b = rectangle(60, 50, 13, 10, 33, 30);
  EXPECT_EQ(outline_distance(a, b).largest, 3.0);
  EXPECT_EQ(outline_distance(a, a).largest, 0.0);
  EXPECT_NEAR(overlap(a, b), 17.0 / 23.0, 1e-15);
}

TEST(OutlineDistance, OneStrayPixelMovesTheLargestAndNotTheMost) {
  const Mask a = rectangle(100, 50, 10, 10, 40, 40);
  Mask b = a;
  b.inside[20 * 100 + 80] = 1;
  const OutlineDistance d = outline_distance(a, b);
  EXPECT_EQ(d.largest, 41.0);
  EXPECT_EQ(d.x, 80);
  EXPECT_EQ(d.y, 20);
  EXPECT_EQ(d.most, 0.0);
}

TEST(OutlineDistance, OfAnEmptyFigureIsNotMeasured) {
  const Mask a = rectangle(10, 10, 2, 2, 5, 5), empty = rectangle(10, 10, 0, 0, 0, 0);
  EXPECT_TRUE(std::isnan(outline_distance(a, empty).largest));
  EXPECT_TRUE(std::isnan(outline_distance(empty, empty).most));
  EXPECT_TRUE(std::isnan(overlap(empty, empty)));
  EXPECT_EQ(overlap(a, empty), 0.0);
}

TEST(Silhouette, TakesWhatIsCoveredAndNothingThatIsNotANumber) {
  const std::vector<float> alpha{0.0f, 0.49f, 0.5f, 1.0f, kNan, 2.0f};
  EXPECT_EQ(silhouette({6, 1, 1, alpha}, 0).inside, (std::vector<std::uint8_t>{0, 0, 1, 1, 0, 1}));
}

TEST(MatteCentre, IsTheMiddleWeightedByCoverage) {
  const std::vector<float> matte{0, 0, 0, 0, 1, 0.5f, 0, 0, 0};
  const glm::dvec2 centre = matte_centre({3, 3, 1, matte}, 0);
  EXPECT_NEAR(centre.x, 1.5 + 1.0 / 3.0, 1e-12);
  EXPECT_NEAR(centre.y, 1.5, 1e-12);
  EXPECT_TRUE(std::isnan(matte_centre({3, 1, 1, std::span(matte).first(3)}, 0).x));
}

TEST(NormalDifference, IsTheAngleWhateverTheLength) {
  std::vector<float> a, b;
  for (int i = 0; i < 100; ++i) {
    a.insert(a.end(), {0.0f, 0.0f, 1.0f});
    const double angle = radians_from(i < 90 ? 1.0 : 40.0);
    b.insert(b.end(), {0.0f, static_cast<float>(2.0 * std::sin(angle)),
                       static_cast<float>(2.0 * std::cos(angle))});
  }
  const NormalDifference d = normal_difference({10, 10, 3, a}, {10, 10, 3, b});
  EXPECT_EQ(d.statistics.count, 100u);
  EXPECT_NEAR(d.statistics.mean, 0.9 * 1.0 + 0.1 * 40.0, 1e-5);
  EXPECT_NEAR(d.statistics.median, 1.0, 1e-5);
  EXPECT_NEAR(d.statistics.p95, 40.0, 1e-5);
  EXPECT_EQ(d.statistics.y, 9);
  EXPECT_NEAR(d.share_over[0], 0.1, 1e-12);
  EXPECT_NEAR(d.share_over[3], 0.1, 1e-12);
}

TEST(NormalDifference, SmallAnglesKeepTheirDigits) {
  const float small = 1e-4f;  // 0.0057 deg, which acos would make 0.02 or 0
  const std::vector<float> a{0, 0, 1}, b{small, 0, 1};
  EXPECT_NEAR(normal_difference({1, 1, 3, a}, {1, 1, 3, b}).statistics.mean, degrees(1e-4), 1e-8);
}

TEST(NormalDifference, LeavesOutTheBackground) {
  const std::vector<float> a{0, 0, 0, 0, 0, 1}, b{0, 1, 0, 0, 0, 1};
  const NormalDifference d = normal_difference({2, 1, 3, a}, {2, 1, 3, b});
  EXPECT_EQ(d.statistics.count, 1u);
  EXPECT_TRUE(std::isnan(d.map[0]));
  const std::vector<float> none(6, 0.0f);
  EXPECT_TRUE(std::isnan(normal_difference({2, 1, 3, none}, {2, 1, 3, b}).statistics.mean));
}

/// Layers of a ball of radius 0.5 seen from far away along -Z, optionally with a crease across it.
struct BallLayers {
  int size = 64;
  std::vector<float> position, normal, object, depth;
  explicit BallLayers(double crease_deg) {
    const double radius = 0.5, scale = 1.2 / size, distance = 10.0;
    for (int y = 0; y < size; ++y)
      for (int x = 0; x < size; ++x) {
        const double px = (x + 0.5 - 0.5 * size) * scale, py = (0.5 * size - y - 0.5) * scale;
        const double zz = radius * radius - px * px - py * py;
        const bool hit = zz > 0.0;
        const double pz = hit ? std::sqrt(zz) : 0.0;
        glm::dvec3 n(px / radius, py / radius, pz / radius);
        if (x >= size / 2) n = rotation(glm::dvec3(0, radians_from(crease_deg), 0)) * n;
        for (double v : {px, py, pz}) position.push_back(hit ? static_cast<float>(v) : 0.0f);
        for (int c = 0; c < 3; ++c) normal.push_back(hit ? static_cast<float>(n[c]) : 0.0f);
        object.push_back(hit ? 1.0f : 0.0f);
        depth.push_back(hit ? static_cast<float>(distance - pz) : 0.0f);
      }
  }
  SurfaceCurvature measure() const {
    return surface_curvature({size, size, 3, position}, {size, size, 3, normal},
                             {size, size, 1, object}, {size, size, 1, depth}, 1.2 / size / 10.0);
  }
};

TEST(SurfaceCurvature, OfABallIsOneOverItsRadius) {
  const SurfaceCurvature c = BallLayers(0.0).measure();
  EXPECT_NEAR(c.statistics.median, 2.0, 0.01);
  // A chord is shorter than its arc, so steep pixels read a little more.
  EXPECT_NEAR(c.statistics.largest, 2.0, 0.05);
}

TEST(SurfaceCurvature, ACreaseStandsOutWhereItIs) {
  const SurfaceCurvature c = BallLayers(10.0).measure();
  EXPECT_EQ(c.statistics.x, 31);
  EXPECT_GT(c.statistics.largest, 2.0 + radians_from(9.0) / (1.2 / 64) * 0.5);
  EXPECT_NEAR(c.statistics.median, 2.0, 0.01);
}

TEST(MotionResidual, IsNothingForAPictureThatOnlyMoved) {
  const int width = 40, height = 20;
  std::vector<float> before, now, motion, id(static_cast<std::size_t>(width) * height, 1.0f);
  const auto shade = [](double x, double y) { return static_cast<float>(0.1 * x + 0.03 * y); };
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      before.push_back(shade(x, y));
      now.push_back(shade(x - 2.5, y - 1.25));
      motion.insert(motion.end(), {2.5f, 1.25f});
    }
  const auto residual = [&] {
    return motion_residual({width, height, 1, before}, {width, height, 1, now},
                           {width, height, 2, motion}, {width, height, 1, id},
                           {width, height, 1, id}, 1);
  };
  EXPECT_LT(residual().largest, 1e-5);
  EXPECT_GT(residual().count, 600u);
  now[10 * width + 20] += 0.5f;  // something popped
  EXPECT_NEAR(residual().largest, 0.5, 1e-5);
  EXPECT_EQ(residual().x, 20);
  EXPECT_EQ(residual().y, 10);
}

TEST(MotionResidual, LooksAtNoPixelThatCameFromBesideAnotherObject) {
  // The middle of four by four comes from between its four neighbours of the frame before.
  const std::vector<float> shade(16, 0.5f), motion(32, 0.5f);
  std::vector<float> now(16, 0.0f), before(16, 1.0f);
  now[2 * 4 + 2] = 1.0f;
  const auto count = [&] {
    return motion_residual({4, 4, 1, shade}, {4, 4, 1, shade}, {4, 4, 2, motion}, {4, 4, 1, before},
                           {4, 4, 1, now}, 1)
        .count;
  };
  EXPECT_EQ(count(), 1u);
  for (int place = 0; place < 16; ++place) {
    const int x = place % 4, y = place / 4;
    before[place] = 2.0f;
    EXPECT_EQ(count(), (x == 1 || x == 2) && (y == 1 || y == 2) ? 0u : 1u) << x << " " << y;
    before[place] = 1.0f;
  }
}

TEST(NoiseTest, PassesTwoNoisyRendersOfOnePictureAndFailsAnotherPicture) {
  std::mt19937_64 rng(3);
  const auto gauss = [&] {  // sum of uniforms: bounded, and the same on every machine
    double sum = -6.0;
    for (int i = 0; i < 12; ++i) sum += static_cast<double>(rng() >> 11) * 0x1p-53;
    return sum;
  };
  const int size = 64;
  const double sigma = 0.05;
  std::vector<float> a, b, shifted, variance(size * size, static_cast<float>(sigma * sigma));
  for (int i = 0; i < size * size; ++i) {
    a.push_back(static_cast<float>(0.5 + sigma * gauss()));
    b.push_back(static_cast<float>(0.5 + sigma * gauss()));
    shifted.push_back(b.back() + (i < 100 ? 0.6f : 0.0f));
  }
  const ImageView va{size, size, 1, variance};
  const NoiseTest same = noise_test({size, size, 1, a}, va, {size, size, 1, b}, va);
  EXPECT_TRUE(same.alike);
  EXPECT_GT(same.bound, 4.0);
  EXPECT_FALSE(noise_test({size, size, 1, a}, va, {size, size, 1, shifted}, va).alike);
  b[7] = kNan;
  EXPECT_FALSE(noise_test({size, size, 1, a}, va, {size, size, 1, b}, va).alike);
}

TEST(RobustScores, OneFlipStandsOutOfItsSweepAndABusySweepIsItsOwnMeasure) {
  std::vector<double> quiet(90), busy(90);
  std::mt19937 rng(4);
  for (int i = 0; i < 90; ++i) {
    const double noise = (rng() % 1000) / 1000.0;
    quiet[i] = 0.010 + 0.001 * noise;
    busy[i] = 0.2 + 0.1 * noise;
  }
  quiet[57] = 0.05;
  const std::vector<double> q = robust_scores(quiet, 1e-4), b = robust_scores(busy, 1e-4);
  EXPECT_GT(q[57], 8.0);
  for (int i = 0; i < 90; ++i) {
    if (i != 57) {
      EXPECT_LT(std::abs(q[i]), 8.0);
    }
    EXPECT_LT(std::abs(b[i]), 8.0);
  }
}

TEST(RobustScores, KeepWhatWasNotMeasuredOut) {
  const std::vector<double> series{1.0, kNan, 1.0, 5.0};
  const std::vector<double> score = robust_scores(series, 0.1);
  EXPECT_TRUE(std::isnan(score[1]));
  EXPECT_EQ(score[0], 0.0);
  EXPECT_NEAR(score[3], 40.0, 1e-12);
}

TEST(Images, ThatDoNotMatchAreRefusedWithBothSizes) {
  const std::vector<float> data(12, 0.0f);
  try {
    normal_difference({2, 2, 3, data}, {4, 1, 3, data});
    FAIL();
  } catch (const ImageError& error) {
    EXPECT_NE(std::string(error.what()).find("2x2"), std::string::npos);
    EXPECT_NE(std::string(error.what()).find("4x1"), std::string::npos);
  }
  EXPECT_THROW(normal_difference({2, 2, 3, std::span(data).first(9)}, {2, 2, 3, data}), ImageError);
}

}  // namespace
}  // namespace backbend::validate
