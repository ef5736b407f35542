#include "validate/metrics/image/frame_difference.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace backbend::validate {
namespace {

constexpr int kEdge = 48;

/// A grey disc on black with its alpha, normals that face the camera, and a variance where asked.
render::Frame disc(double centre_x, double grey = 0.4, double variance = -1.0) {
  render::Frame frame;
  frame.width = frame.height = kEdge;
  render::Layer color{{"R", "G", "B", "A"}, false, {}}, normal{{"N.X", "N.Y", "N.Z"}, false, {}},
      spread{{"variance.R", "variance.G", "variance.B"}, false, {}};
  for (int y = 0; y < kEdge; ++y)
    for (int x = 0; x < kEdge; ++x) {
      const bool inside = std::hypot(x - centre_x, y - 24.0) < 12.0;
      const float value = inside ? static_cast<float>(grey) : 0.0f;
      color.data.insert(color.data.end(), {value, value, value, inside ? 1.0f : 0.0f});
      normal.data.insert(normal.data.end(), {0.0f, 0.0f, inside ? 1.0f : 0.0f});
      spread.data.insert(spread.data.end(), 3, static_cast<float>(variance));
    }
  frame.layers = {color, normal};
  if (variance >= 0.0) frame.layers.push_back(spread);
  return frame;
}

const PictureMeasure& measure(const FrameDifference& d, const std::string& name) {
  for (const PictureMeasure& m : d.measures)
    if (m.name == name) return m;
  throw std::runtime_error("no measure " + name);
}

TEST(FrameDifference, OfAFrameAndItselfIsNothingAtAll) {
  const FrameDifference d = frame_difference(disc(24), disc(24));
  EXPECT_TRUE(d.identical);
  EXPECT_EQ(d.verdict(), Verdict::pass);
  EXPECT_EQ(measure(d, "perceptual_hdr_mean").value, 0.0);
  EXPECT_EQ(measure(d, "silhouette_overlap").value, 1.0);
  EXPECT_EQ(measure(d, "outline_largest").value, 0.0);
  EXPECT_EQ(measure(d, "normal_largest").value, 0.0);
}

TEST(FrameDifference, ComparesNoiseOnlyWhereBothFramesTellTheirs) {
  EXPECT_TRUE(frame_difference(disc(24, 0.4, 1e-4), disc(24, 0.4, 1e-4)).noise.has_value());
  const render::Frame plain = disc(24), told = disc(24, 0.4, 1e-4);
  for (const auto& [a, b] : {std::pair(plain, told), std::pair(told, plain)}) {
    const FrameDifference d = frame_difference(a, b);
    EXPECT_FALSE(d.noise.has_value());
    EXPECT_EQ(measure(d, "perceptual_hdr_mean").verdict, Verdict::pass);
  }
}

TEST(FrameDifference, MeasuresAMoveInPixels) {
  const FrameDifference d = frame_difference(disc(24), disc(27));
  EXPECT_FALSE(d.identical);
  EXPECT_EQ(d.verdict(), Verdict::fail);
  EXPECT_EQ(measure(d, "outline_largest").value, 3.0);
  EXPECT_EQ(measure(d, "outline_p95").verdict, Verdict::fail);
  EXPECT_EQ(measure(d, "perceptual_hdr_mean").verdict, Verdict::fail);
  // Where both show the disc it faces the same way.
  EXPECT_EQ(measure(d, "normal_mean").verdict, Verdict::pass);
}

/// A ball of this radius, twelve away, as its layers of position, normal and depth show it.
render::Frame ball(double radius) {
  render::Frame frame = disc(24);
  const double pixel = 0.02;
  render::Layer place{{"P.X", "P.Y", "P.Z"}, false, {}}, normal{{"N.X", "N.Y", "N.Z"}, false, {}},
      depth{{"Z"}, false, {}};
  for (int y = 0; y < kEdge; ++y)
    for (int x = 0; x < kEdge; ++x) {
      // The camera looks along -Z from 12 at the ball in the origin; rays are as good as parallel.
      const double px = (x - 24) * pixel * 12, py = (24 - y) * pixel * 12;
      const double pz = std::sqrt(std::max(0.0, radius * radius - px * px - py * py));
      for (const double v : {px, py, pz}) {
        place.data.push_back(static_cast<float>(v));
        normal.data.push_back(static_cast<float>(v / radius));
      }
      depth.data.push_back(static_cast<float>(12.0 - pz));
    }
  frame.layers[1] = normal;
  frame.layers.push_back(place);
  frame.layers.push_back(depth);
  return frame;
}

TEST(FrameDifference, SaysHowMuchSharperASurfaceIsBent) {
  const FrameDifference d = frame_difference(ball(8.0), ball(4.0));
  EXPECT_NEAR(measure(d, "curvature_b_over_a").value, 2.0, 0.1);
  EXPECT_EQ(measure(d, "curvature_b_over_a").verdict, Verdict::pass);  // told, and not judged
  EXPECT_NEAR(measure(frame_difference(ball(5.0), ball(5.0)), "curvature_b_over_a").value, 1.0,
              1e-12);
  // Without a layer of positions nothing is said, and nothing is missing.
  EXPECT_THROW(measure(frame_difference(disc(24), disc(24)), "curvature_b_over_a"),
               std::runtime_error);
}

TEST(FrameDifference, LetsNoiseDecideWhereTheVarianceIsKnown) {
  const double variance = 0.0025;  // a standard deviation of 0.05
  render::Frame a = disc(24, 0.4, variance), b = disc(24, 0.4, variance);
  std::mt19937 rng(5);
  for (render::Frame* frame : {&a, &b})
    for (std::size_t p = 0; p < frame->layers[0].data.size(); p += 4)
      for (std::size_t c = 0; c < 3; ++c) {
        double sum = -6.0;  // twelve even draws of variance 1/12 each
        for (int i = 0; i < 12; ++i) sum += (rng() >> 8) * 0x1p-24;
        frame->layers[0].data[p + c] += static_cast<float>(0.05 * sum);
      }
  const FrameDifference noisy = frame_difference(a, b);
  EXPECT_FALSE(noisy.identical);
  EXPECT_GT(measure(noisy, "perceptual_hdr_mean").value, PictureLimits{}.perceptual);
  EXPECT_EQ(noisy.verdict(), Verdict::pass);
  // A disc that is brighter by ten standard deviations is no noise.
  for (std::size_t p = 0; p < b.layers[0].data.size(); p += 4)
    if (b.layers[0].data[p + 3] > 0) b.layers[0].data[p] += 0.5f;
  const FrameDifference brighter = frame_difference(a, b);
  EXPECT_EQ(brighter.verdict(), Verdict::fail);
  EXPECT_EQ(measure(brighter, "within_noise").verdict, Verdict::fail);
}

/// A backdrop that covers all, and a matte whose figure is the disc: number 7, half covered rim.
render::Frame before_a_backdrop(double centre_x) {
  render::Frame frame = disc(centre_x);
  render::Layer matte{{"CryptoAsset00.r", "CryptoAsset00.g"}, false, {}};
  for (int y = 0; y < kEdge; ++y)
    for (int x = 0; x < kEdge; ++x) {
      const double away = std::hypot(x - centre_x, y - 24.0);
      frame.layers[0].data[4 * (static_cast<std::size_t>(y) * kEdge + x) + 3] = 1.0f;
      // Beyond the rim a little of the figure, and around that another number: none.
      matte.data.insert(matte.data.end(), {away < 14.0 ? 7.0f : 0.0f, away < 12.0   ? 1.0f
                                                                      : away < 13.0 ? 0.5f
                                                                                    : 0.49f});
    }
  frame.layers.push_back(matte);
  return frame;
}

TEST(FrameDifference, TakesTheFigureFromItsMatteWhereABackdropCoversAll) {
  const FrameDifference d = frame_difference(before_a_backdrop(20), before_a_backdrop(24));
  EXPECT_EQ(measure(d, "outline_largest").value, 4.0);
  std::size_t both = 0, either = 0;
  for (int y = 0; y < kEdge; ++y)
    for (int x = 0; x < kEdge; ++x) {
      const bool a = std::hypot(x - 20, y - 24) < 13.0, b = std::hypot(x - 24, y - 24) < 13.0;
      both += a && b;
      either += a || b;
    }
  EXPECT_DOUBLE_EQ(measure(d, "silhouette_overlap").value,
                   static_cast<double>(both) / static_cast<double>(either));
  EXPECT_EQ(measure(d, "silhouette_overlap").verdict, Verdict::fail);
  EXPECT_EQ(measure(d, "outline_p95").verdict, Verdict::fail);
}

TEST(FrameDifference, AsksForNoSilhouetteWhereNeitherOrAllIsFigure) {
  for (const float alpha : {0.0f, 1.0f}) {
    render::Frame even = disc(24);
    for (std::size_t i = 3; i < even.layers[0].data.size(); i += 4) even.layers[0].data[i] = alpha;
    const FrameDifference d = frame_difference(even, even);
    EXPECT_TRUE(std::isnan(measure(d, "silhouette_overlap").value));
    EXPECT_EQ(measure(d, "silhouette_overlap").verdict, Verdict::not_applicable);
    // One of them against a figure is a question, and its answer no.
    const FrameDifference one = frame_difference(even, disc(24));
    EXPECT_EQ(measure(one, "silhouette_overlap").verdict, Verdict::fail);
  }
}

TEST(FrameDifference, GivesNoisyOutlinesAPixelAndNoMore) {
  PictureLimits tight;
  tight.outline_px = 0.25;
  const auto outline = [&](double moved, double variance) {
    return measure(
        frame_difference(disc(24, 0.4, variance), disc(24 + moved, 0.4, variance), tight),
        "outline_p95");
  };
  EXPECT_EQ(outline(1, -1).verdict, Verdict::fail);
  EXPECT_EQ(outline(1, -1).limit, 0.25);
  EXPECT_EQ(outline(1, 0.01).verdict, Verdict::pass);
  EXPECT_EQ(outline(1, 0.01).limit, 1.0);
  EXPECT_EQ(outline(2, 0.01).verdict, Verdict::fail);
  tight.outline_px = 2.5;
  EXPECT_EQ(outline(2, 0.01).verdict, Verdict::pass);
}

TEST(FrameDifference, WhatOneSideLacksIsNotMeasured) {
  render::Frame bare = disc(24);
  bare.layers.pop_back();
  const FrameDifference d = frame_difference(disc(24), bare);
  EXPECT_EQ(d.only_a, (std::vector<std::string>{"N.X", "N.Y", "N.Z"}));
  EXPECT_EQ(measure(d, "normal_mean").verdict, Verdict::not_measured);
  EXPECT_EQ(d.verdict(), Verdict::not_measured);
  render::Frame neither = disc(24);
  neither.layers.erase(neither.layers.begin());
  render::Frame other = neither;
  other.layers[0].names = {"Q.X", "Q.Y", "Q.Z"};
  EXPECT_EQ(frame_difference(neither, other).verdict(), Verdict::not_measured);
}

TEST(FrameDifference, AValueThatIsNoNumberIsNotMeasured) {
  render::Frame broken = disc(24);
  broken.layers[0].data[4 * 24 * kEdge] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(frame_difference(disc(24), broken).verdict(), Verdict::not_measured);
}

TEST(FrameDifference, OfDifferentSizesIsRefused) {
  render::Frame small = disc(24);
  small.height = 1;
  for (render::Layer& layer : small.layers) layer.data.resize(kEdge * layer.names.size());
  EXPECT_THROW(frame_difference(disc(24), small), ImageError);
}

}  // namespace
}  // namespace backbend::validate
