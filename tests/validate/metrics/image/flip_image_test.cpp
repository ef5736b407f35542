#include "validate/metrics/image/flip_image.h"

#include <gtest/gtest.h>

#include <cmath>

namespace backbend::validate {
namespace {

constexpr int kSize = 64;
// Golden values were printed with six digits by the authors' own program, which filters in another
// order: they themselves compare means to this tolerance.
constexpr double kMeanTolerance = 1e-4, kPixelTolerance = 2e-3;

struct Picture {
  std::vector<float> data;
  ImageView view(int width = kSize, int height = kSize) const { return {width, height, 3, data}; }
};

template <typename Color>  // (x, y) -> array of three
Picture paint(Color color) {
  Picture p;
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x)
      for (float v : color(x, y)) p.data.push_back(v);
  return p;
}
Picture flat(float r, float g, float b) {
  return paint([=](int, int) { return std::array{r, g, b}; });
}
float linear(double srgb) {
  return static_cast<float>(srgb <= 0.04045 ? srgb / 12.92 : std::pow((srgb + 0.055) / 1.055, 2.4));
}
Picture grey(double srgb) { return flat(linear(srgb), linear(srgb), linear(srgb)); }
Picture edge_at(int place) {
  return paint([=](int x, int) {
    const float v = x < place ? 0.2f : 0.8f;
    return std::array{v, v, v};
  });
}

TEST(PerceptualDifference, AgreesWithItsAuthorsOnFlatColours) {
  const struct {
    Picture a, b;
    double mean;
  } cases[] = {{flat(0, 0, 0), flat(1, 1, 1), 0.967388},
               {flat(0, 1, 0), flat(0, 0, 1), 1.000000},
               {flat(1, 0, 0), flat(0, 1, 0), 0.986665},
               {grey(0.50), grey(0.51), 0.057496},
               {grey(0.50), grey(0.60), 0.285063}};
  for (const auto& c : cases) {
    const PerceptualDifference d = perceptual_difference(c.a.view(), c.b.view());
    EXPECT_NEAR(d.mean, c.mean, kMeanTolerance);
    EXPECT_NEAR(d.largest, c.mean, kPixelTolerance);
  }
}

TEST(PerceptualDifference, AgreesWithItsAuthorsOnEdgesAndPoints) {
  PerceptualDifference d = perceptual_difference(edge_at(32).view(), edge_at(33).view());
  EXPECT_NEAR(d.mean, 0.028312, kMeanTolerance);
  EXPECT_NEAR(d.largest, 0.474634, kPixelTolerance);
  d = perceptual_difference(edge_at(32).view(), edge_at(36).view());
  EXPECT_NEAR(d.mean, 0.085685, kMeanTolerance);
  EXPECT_NEAR(d.largest, 0.800814, kPixelTolerance);
  const Picture plain = flat(0.2f, 0.2f, 0.2f);
  const Picture dot = paint([](int x, int y) {
    const float v = x == 32 && y == 32 ? 1.0f : 0.2f;
    return std::array{v, v, v};
  });
  d = perceptual_difference(plain.view(), dot.view());
  EXPECT_NEAR(d.mean, 0.001095, kMeanTolerance);
  EXPECT_NEAR(d.largest, 0.392289, kPixelTolerance);
  EXPECT_NEAR(d.x, 32, 1);
  EXPECT_NEAR(d.y, 32, 1);
}

TEST(PerceptualDifference, AgreesWithItsAuthorsOnHighDynamicRange) {
  const auto ramp = [](float times) {
    return paint([=](int x, int) {
      const float v = times * std::exp2((x - 32) / 8.0f);
      return std::array{v, 0.8f * v, 0.6f * v};
    });
  };
  const PerceptualDifference d = perceptual_difference_hdr(ramp(1.0f).view(), ramp(1.1f).view());
  EXPECT_NEAR(d.mean, 0.132851, kMeanTolerance);
  EXPECT_NEAR(d.largest, 0.152188, kPixelTolerance);
  EXPECT_NEAR(d.first_stop, -2.5195, 1e-3);
  EXPECT_NEAR(d.last_stop, 1.3555, 1e-3);
  EXPECT_EQ(d.exposure_count, 4);
}

TEST(PerceptualDifference, OfAPictureAndItselfIsNothing) {
  const Picture p = paint([](int x, int y) {
    return std::array{x / 64.0f, y / 64.0f, std::fmod(x * 0.37f + y * 0.11f, 1.0f)};
  });
  EXPECT_EQ(perceptual_difference(p.view(), p.view()).largest, 0.0);
  EXPECT_EQ(perceptual_difference_hdr(p.view(), p.view()).largest, 0.0);
}

TEST(PerceptualDifference, IsTheSameFromBothSides) {
  const Picture a = edge_at(30), b = grey(0.6);
  const PerceptualDifference ab = perceptual_difference(a.view(), b.view());
  const PerceptualDifference ba = perceptual_difference(b.view(), a.view());
  EXPECT_EQ(ab.map, ba.map);
}

TEST(PerceptualDifference, WhatIsNotANumberIsNotMeasured) {
  const Picture a = grey(0.5);
  Picture b = a;
  b.data[100] = std::nanf("");
  EXPECT_TRUE(std::isnan(perceptual_difference(a.view(), b.view()).mean));
  EXPECT_TRUE(std::isnan(perceptual_difference_hdr(b.view(), a.view()).largest));
}

TEST(PerceptualDifference, RefusesPicturesThatDoNotMatch) {
  const Picture a = grey(0.5);
  EXPECT_THROW(perceptual_difference(a.view(), a.view(32, 64)), ImageError);
  EXPECT_THROW(perceptual_difference(a.view(64, 65), a.view(64, 65)), ImageError);
  EXPECT_THROW(perceptual_difference({64, 64, 1, a.data}, a.view()), ImageError);
  EXPECT_THROW(perceptual_difference({}, {}), ImageError);
}

TEST(PerceptualDifference, TakesAPictureOfOnePixel) {
  const std::vector<float> black{0, 0, 0}, white{1, 1, 1};
  EXPECT_NEAR(perceptual_difference({1, 1, 3, black}, {1, 1, 3, white}).mean, 0.967388, 1e-4);
}

}  // namespace
}  // namespace backbend::validate
