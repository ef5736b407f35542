#include "validate/metrics/image/flip_image.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/vec2.hpp>

#include "validate/metrics/image/color_difference.h"
#include "validate/metrics/math/rotation.h"

namespace backbend::validate {
namespace {

/// One channel of a picture.
struct Plane {
  int width = 0, height = 0;
  std::vector<float> value;

  Plane(int w, int h) : width(w), height(h), value(static_cast<std::size_t>(w) * h) {}
  float* row(int y) { return value.data() + static_cast<std::size_t>(y) * width; }
  const float* row(int y) const { return value.data() + static_cast<std::size_t>(y) * width; }
};
using Planes = std::array<Plane, 3>;

Planes planes(int width, int height) {
  return {Plane(width, height), Plane(width, height), Plane(width, height)};
}

/// One row of taps, centre in the middle; borders repeat the outermost pixel.
using Taps = std::vector<float>;

/// Adds the convolution of `in` by across (x) and down (y) to `out`.
void convolve(const Plane& in, const Taps& across, const Taps& down, Plane& out, Plane& scratch) {
  const int radius = static_cast<int>(across.size() / 2), width = in.width, height = in.height;
  std::vector<float> padded(static_cast<std::size_t>(width) + 2 * radius);
  for (int y = 0; y < height; ++y) {
    const float* row = in.row(y);
    std::fill_n(padded.begin(), radius, row[0]);
    std::copy_n(row, width, padded.begin() + radius);
    std::fill_n(padded.begin() + radius + width, radius, row[width - 1]);
    float* result = scratch.row(y);
    std::fill_n(result, width, 0.0f);
    for (std::size_t k = 0; k < across.size(); ++k) {
      const float tap = across[k];
      const float* shifted = padded.data() + k;
      for (int x = 0; x < width; ++x) result[x] += tap * shifted[x];
    }
  }
  for (int y = 0; y < height; ++y) {
    float* result = out.row(y);
    for (std::size_t k = 0; k < down.size(); ++k) {
      const float tap = down[k];
      const float* row = scratch.row(std::clamp(y + static_cast<int>(k) - radius, 0, height - 1));
      for (int x = 0; x < width; ++x) result[x] += tap * row[x];
    }
  }
}

/// The eye's contrast sensitivity of one opponent channel: a sum of Gaussians
/// a sqrt(pi / b) exp(-pi^2 x^2 / b), x in degrees, scaled so that the whole sums to one.
struct Sensitivity {
  struct Term {
    Taps across, down;
  };
  std::vector<Term> term;

  Sensitivity(std::initializer_list<glm::dvec2> amplitude_and_width, int radius, double ppd) {
    double sum = 0.0;
    std::vector<std::vector<double>> taps;
    std::vector<double> weight;
    for (const glm::dvec2& ab : amplitude_and_width) {
      std::vector<double> g;
      double one = 0.0;
      for (int i = -radius; i <= radius; ++i) {
        const double x = i / ppd;
        g.push_back(std::exp(-kPi * kPi * x * x / ab.y));
        one += g.back();
      }
      taps.push_back(g);
      weight.push_back(ab.x * std::sqrt(kPi / ab.y));
      sum += weight.back() * one * one;
    }
    for (std::size_t i = 0; i < taps.size(); ++i) {
      Term t;
      for (double g : taps[i]) {
        t.across.push_back(static_cast<float>(g));
        t.down.push_back(static_cast<float>(g * weight[i] / sum));
      }
      term.push_back(std::move(t));
    }
  }
};

/// Gaussian and its first two derivatives: positive taps sum to one, negative to minus one.
struct FeatureTaps {
  Taps smooth, edge, point;

  explicit FeatureTaps(double ppd) {
    constexpr double kFeatureWidth = 0.082;  // degrees: the finest that the eye tells apart
    const double sigma = 0.5 * kFeatureWidth * ppd;
    const int radius = static_cast<int>(std::ceil(3.0 * sigma));
    std::vector<double> g, first, second;
    for (int i = -radius; i <= radius; ++i) {
      const double x = i, gauss = std::exp(-x * x / (2.0 * sigma * sigma));
      g.push_back(gauss);
      first.push_back(-x * gauss);
      second.push_back((x * x / (sigma * sigma) - 1.0) * gauss);
    }
    smooth = balanced(g);
    edge = balanced(first);
    point = balanced(second);
  }

  static Taps balanced(const std::vector<double>& taps) {
    double up = 0.0, down = 0.0;
    for (double t : taps) (t > 0.0 ? up : down) += std::abs(t);
    Taps out;
    for (double t : taps)
      out.push_back(static_cast<float>(t > 0.0 ? t / up : t < 0.0 ? t / down : 0.0));
    return out;
  }
};

void clear(Plane& plane) { std::ranges::fill(plane.value, 0.0f); }

/// Strength of edges and points in each pixel of a luminance plane.
struct Features {
  Plane edge, point;
};
Features features(const Plane& luminance, const FeatureTaps& taps, Plane& scratch) {
  Features out{Plane(luminance.width, luminance.height), Plane(luminance.width, luminance.height)};
  Plane vertical(luminance.width, luminance.height);
  for (Plane* plane : {&out.edge, &out.point}) {
    const Taps& derivative = plane == &out.edge ? taps.edge : taps.point;
    convolve(luminance, derivative, taps.smooth, *plane, scratch);
    clear(vertical);
    convolve(luminance, taps.smooth, derivative, vertical, scratch);
    for (std::size_t i = 0; i < plane->value.size(); ++i)
      plane->value[i] =
          std::sqrt(plane->value[i] * plane->value[i] + vertical.value[i] * vertical.value[i]);
  }
  return out;
}

/// What the eye sees of a picture: its filtered colours in Hunt-adjusted CIELAB, and its features.
struct Seen {
  Planes lab;
  Features feature;
};

class Eye {
 public:
  explicit Eye(double ppd)
      : radius_(static_cast<int>(std::ceil(3.0 * std::sqrt(0.04 / (2.0 * kPi * kPi)) * ppd))),
        sensitivity_{Sensitivity({{1.0, 0.0047}}, radius_, ppd),
                     Sensitivity({{1.0, 0.0053}}, radius_, ppd),
                     Sensitivity({{34.1, 0.04}, {13.5, 0.025}}, radius_, ppd)},
        taps_(ppd),
        farthest_(largest_color_distance()) {}

  /// `rgb`: linear, in 0..1.
  Seen see(const Planes& rgb) const {
    const int width = rgb[0].width, height = rgb[0].height;
    Planes opponent = planes(width, height), seen = planes(width, height);
    Plane luminance(width, height), scratch(width, height);
    for (std::size_t i = 0; i < luminance.value.size(); ++i) {
      const float in[3] = {rgb[0].value[i], rgb[1].value[i], rgb[2].value[i]};
      float out[3];
      color_spaces().opponent_from_rgb.apply(in, out);
      for (int c = 0; c < 3; ++c) opponent[c].value[i] = out[c];
      luminance.value[i] = (out[0] + 16.0f) / 116.0f;
    }
    for (int c = 0; c < 3; ++c)
      for (const Sensitivity::Term& term : sensitivity_[c].term)
        convolve(opponent[c], term.across, term.down, seen[c], scratch);
    for (std::size_t i = 0; i < luminance.value.size(); ++i) {
      const float in[3] = {seen[0].value[i], seen[1].value[i], seen[2].value[i]};
      float color[3], lab[3];
      color_spaces().rgb_from_opponent.apply(in, color);
      for (float& v : color) v = std::clamp(v, 0.0f, 1.0f);
      hunt_lab(color, lab);
      for (int c = 0; c < 3; ++c) seen[c].value[i] = lab[c];
    }
    return {std::move(seen), features(luminance, taps_, scratch)};
  }

  std::vector<float> compare(const Seen& a, const Seen& b) const {
    constexpr float kKnee = 0.4f, kKneeValue = 0.95f;  // of the farthest distance, and its result
    const float knee = kKnee * farthest_;
    std::vector<float> map(a.lab[0].value.size());
    for (std::size_t i = 0; i < map.size(); ++i) {
      const float la[3] = {a.lab[0].value[i], a.lab[1].value[i], a.lab[2].value[i]};
      const float lb[3] = {b.lab[0].value[i], b.lab[1].value[i], b.lab[2].value[i]};
      const float distance = std::pow(hyab(la, lb), kColorPower);
      const float color = distance < knee ? distance * (kKneeValue / knee)
                                          : kKneeValue + (distance - knee) / (farthest_ - knee) *
                                                             (1.0f - kKneeValue);
      const float feature = std::max(std::abs(a.feature.edge.value[i] - b.feature.edge.value[i]),
                                     std::abs(a.feature.point.value[i] - b.feature.point.value[i]));
      const float strength =
          std::min(1.0f, std::sqrt(feature * static_cast<float>(std::sqrt(0.5))));
      map[i] = std::pow(std::min(color, 1.0f), 1.0f - strength);
    }
    return map;
  }

 private:
  int radius_;
  std::array<Sensitivity, 3> sensitivity_;
  FeatureTaps taps_;
  float farthest_;
};

Planes read(const ImageView& image) {
  Planes out = planes(image.width, image.height);
  for (std::size_t i = 0; i < out[0].value.size(); ++i)
    for (int c = 0; c < 3; ++c)
      out[c].value[i] = image.data[i * static_cast<std::size_t>(image.channels) + c];
  return out;
}

bool finite(const Planes& p) {
  for (const Plane& plane : p)
    for (float v : plane.value)
      if (!std::isfinite(v)) return false;
  return true;
}

void clamp_to_display(Planes& p) {
  for (Plane& plane : p)
    for (float& v : plane.value) v = std::clamp(v, 0.0f, 1.0f);
}

void summarise(PerceptualDifference& out, int width) {
  double sum = 0.0;
  out.largest = -1.0;
  for (std::size_t i = 0; i < out.map.size(); ++i) {
    sum += out.map[i];
    if (out.map[i] > out.largest) {
      out.largest = out.map[i];
      out.x = static_cast<int>(i % static_cast<std::size_t>(width));
      out.y = static_cast<int>(i / static_cast<std::size_t>(width));
    }
  }
  out.mean = sum / static_cast<double>(out.map.size());
}

/// (x^2 a + x b + c) / (x^2 d + x e + f): the ACES fit, its input scaled by 0.6.
struct ToneCurve {
  double a = 0.6 * 0.6 * 2.51, b = 0.6 * 0.03, c = 0.0, d = 0.6 * 0.6 * 2.43, e = 0.6 * 0.59,
         f = 0.14;

  float operator()(float x) const {
    const double v = x;
    return static_cast<float>((v * v * a + v * b + c) / (v * v * d + v * e + f));
  }
  /// The positive x whose tone is `y`.
  double inverse(double y) const {
    const double p = a - y * d, q = b - y * e, r = c - y * f;
    return (-q + std::sqrt(q * q - 4.0 * p * r)) / (2.0 * p);
  }
};

Planes exposed(const Planes& in, double stops, const ToneCurve& tone) {
  Planes out = in;
  const float scale = static_cast<float>(std::exp2(stops));
  for (Plane& plane : out)
    for (float& v : plane.value) v = std::clamp(tone(v * scale), 0.0f, 1.0f);
  return out;
}

/// Upper median and largest luminance of a picture.
std::pair<double, double> median_and_largest(const Planes& rgb) {
  const ColorMap& map = color_spaces().white_xyz_from_rgb;
  std::vector<float> y(rgb[0].value.size());
  for (std::size_t i = 0; i < y.size(); ++i) {
    const float in[3] = {rgb[0].value[i], rgb[1].value[i], rgb[2].value[i]};
    float xyz[3];
    map.apply(in, xyz);
    y[i] = xyz[1];
  }
  const float largest = *std::ranges::max_element(y);
  const auto middle = y.begin() + static_cast<std::ptrdiff_t>(y.size() / 2);
  std::nth_element(y.begin(), middle, y.end());
  return {*middle, largest};
}

}  // namespace

PerceptualDifference perceptual_difference(const ImageView& reference, const ImageView& test,
                                           double pixels_per_degree) {
  require_alike(reference, test, 3);
  PerceptualDifference out;
  Planes a = read(reference), b = read(test);
  if (!finite(a) || !finite(b)) return out;
  clamp_to_display(a);
  clamp_to_display(b);
  const Eye eye(pixels_per_degree);
  out.map = eye.compare(eye.see(a), eye.see(b));
  summarise(out, reference.width);
  return out;
}

PerceptualDifference perceptual_difference_hdr(const ImageView& reference, const ImageView& test,
                                               double pixels_per_degree) {
  require_alike(reference, test, 3);
  PerceptualDifference out;
  Planes a = read(reference), b = read(test);
  if (!finite(a) || !finite(b)) return out;
  for (Planes* p : {&a, &b})
    for (Plane& plane : *p)
      for (float& v : plane.value) v = std::max(v, 0.0f);
  const ToneCurve tone;
  constexpr double kBright = 0.85;  // of the display: where neither end is clipped
  constexpr double kBlack = 1e-6;   // a picture whose median is black is exposed for this instead
  const auto [median, largest] = median_and_largest(a);
  const double goal = tone.inverse(kBright);
  out.first_stop = std::log2(goal / std::max(largest, kBlack));
  out.last_stop = std::log2(goal / std::max(median, kBlack));
  out.exposure_count = std::max(2, static_cast<int>(std::ceil(out.last_stop - out.first_stop)));
  const Eye eye(pixels_per_degree);
  out.map.assign(a[0].value.size(), 0.0f);
  out.exposure.assign(out.map.size(), 0);
  for (int k = 0; k < out.exposure_count; ++k) {
    const double stop =
        out.first_stop + (out.last_stop - out.first_stop) * k / (out.exposure_count - 1);
    const std::vector<float> map =
        eye.compare(eye.see(exposed(a, stop, tone)), eye.see(exposed(b, stop, tone)));
    for (std::size_t i = 0; i < map.size(); ++i)
      if (map[i] > out.map[i]) {
        out.map[i] = map[i];
        out.exposure[i] = static_cast<std::uint8_t>(std::min(k, 255));
      }
  }
  summarise(out, reference.width);
  return out;
}

}  // namespace backbend::validate
