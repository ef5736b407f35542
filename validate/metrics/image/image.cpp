#include "validate/metrics/image/image.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "validate/metrics/math/rotation.h"

namespace backbend::validate {
namespace {

constexpr float kNoValue = std::numeric_limits<float>::quiet_NaN();

void require_whole(const ImageView& image, int channels) {
  if (image.width < 1 || image.height < 1)
    throw ImageError("image of " + std::to_string(image.width) + "x" +
                     std::to_string(image.height) + " pixels; expected at least one");
  if (image.channels < channels)
    throw ImageError("image of " + std::to_string(image.channels) + " channels; expected " +
                     std::to_string(channels));
  if (image.data.size() < image.pixel_count() * static_cast<std::size_t>(image.channels))
    throw ImageError("image holds fewer values than its size says");
}

/// Quantile by rank: the value that at least `share` of all do not exceed.
double quantile(std::vector<double>& values, double share) {
  const double rank = std::ceil(share * static_cast<double>(values.size()));
  const std::size_t index = static_cast<std::size_t>(std::max(1.0, rank)) - 1;
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(index),
                   values.end());
  return values[index];
}

PixelStatistics statistics_of(std::span<const float> map, int width) {
  PixelStatistics out;
  std::vector<double> values;
  double sum = 0.0;
  for (std::size_t i = 0; i < map.size(); ++i) {
    if (std::isnan(map[i])) continue;
    const double value = map[i];
    values.push_back(value);
    sum += value;
    if (!(value <= out.largest)) {
      out.largest = value;
      out.x = static_cast<int>(i % static_cast<std::size_t>(width));
      out.y = static_cast<int>(i / static_cast<std::size_t>(width));
    }
  }
  out.count = values.size();
  if (values.empty()) return out;
  out.mean = sum / static_cast<double>(values.size());
  out.median = quantile(values, 0.5);
  out.p95 = quantile(values, 0.95);
  out.p99 = quantile(values, 0.99);
  out.p999 = quantile(values, 0.999);
  return out;
}

glm::dvec3 vector_at(const ImageView& image, int x, int y) {
  return {image.at(x, y, 0), image.at(x, y, 1), image.at(x, y, 2)};
}

/// Inverse of the normal distribution by bisection of erfc: exact to rounding, and short.
double normal_quantile(double upper_tail) {
  double low = 0.0, high = 40.0;
  for (int i = 0; i < 200; ++i) {
    const double middle = 0.5 * (low + high);
    (0.5 * std::erfc(middle / std::sqrt(2.0)) > upper_tail ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

/// Throws unless `b` is whole, has these channels and the size of `a`.
void require_beside(const ImageView& a, const ImageView& b, int channels) {
  require_whole(b, channels);
  if (a.width != b.width || a.height != b.height)
    throw ImageError("images of " + std::to_string(a.width) + "x" + std::to_string(a.height) +
                     " and " + std::to_string(b.width) + "x" + std::to_string(b.height) +
                     " pixels cannot be compared");
}

}  // namespace

void require_alike(const ImageView& a, const ImageView& b, int channels) {
  require_whole(a, channels);
  require_beside(a, b, channels);
}

glm::dvec2 matte_centre(const ImageView& image, int channel) {
  require_whole(image, channel + 1);
  glm::dvec2 sum(0.0);
  double weight = 0.0;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const double w = image.at(x, y, channel);
      sum += w * glm::dvec2(x + 0.5, y + 0.5);
      weight += w;
    }
  if (!(weight > 0.0)) return glm::dvec2(std::numeric_limits<double>::quiet_NaN());
  return sum / weight;
}

NormalDifference normal_difference(const ImageView& a, const ImageView& b) {
  require_alike(a, b, 3);
  NormalDifference out;
  out.map.assign(a.pixel_count(), kNoValue);
  constexpr std::array<double, 4> kOver{5.0, 11.25, 22.5, 30.0};
  std::array<std::size_t, 4> over{};
  for (int y = 0; y < a.height; ++y)
    for (int x = 0; x < a.width; ++x) {
      const glm::dvec3 n = vector_at(a, x, y), m = vector_at(b, x, y);
      // A background pixel has no normal; a mixed one at an edge has a short one.
      if (!(glm::dot(n, n) > 0.25 && glm::dot(m, m) > 0.25)) continue;
      const double angle = degrees(angle_between(n, m));
      out.map[static_cast<std::size_t>(y) * a.width + x] = static_cast<float>(angle);
      for (std::size_t i = 0; i < kOver.size(); ++i) over[i] += angle > kOver[i];
    }
  out.statistics = statistics_of(out.map, a.width);
  for (std::size_t i = 0; i < kOver.size(); ++i)
    out.share_over[i] = out.statistics.count == 0 ? std::numeric_limits<double>::quiet_NaN()
                                                  : static_cast<double>(over[i]) /
                                                        static_cast<double>(out.statistics.count);
  return out;
}

SurfaceCurvature surface_curvature(const ImageView& position, const ImageView& normal,
                                   const ImageView& object, const ImageView& depth,
                                   double pixel_angle) {
  require_alike(position, normal, 3);
  require_beside(position, object, 1);
  require_beside(position, depth, 1);
  SurfaceCurvature out;
  out.map.assign(position.pixel_count(), kNoValue);
  const auto compare = [&](int x, int y, int x2, int y2) {
    if (x2 >= position.width || y2 >= position.height) return kNoValue;
    const float id = object.at(x, y, 0);
    if (!(id != 0.0f) || id != object.at(x2, y2, 0)) return kNoValue;
    const double near = depth.at(x, y, 0), far = depth.at(x2, y2, 0);
    const double footprint = pixel_angle * std::min(near, far);
    if (!(std::abs(near - far) < 2.0 * footprint)) return kNoValue;
    const double apart = glm::distance(vector_at(position, x, y), vector_at(position, x2, y2));
    if (!(apart > 0.0)) return kNoValue;
    return static_cast<float>(angle_between(vector_at(normal, x, y), vector_at(normal, x2, y2)) /
                              apart);
  };
  for (int y = 0; y < position.height; ++y)
    for (int x = 0; x < position.width; ++x) {
      const float right = compare(x, y, x + 1, y), below = compare(x, y, x, y + 1);
      // fmax drops a NaN for the other value, which is what "the larger of those measured" means.
      out.map[static_cast<std::size_t>(y) * position.width + x] = std::fmax(right, below);
    }
  out.statistics = statistics_of(out.map, position.width);
  return out;
}

PixelStatistics motion_residual(const ImageView& before, const ImageView& now,
                                const ImageView& motion, const ImageView& object_before,
                                const ImageView& object_now, int channels) {
  require_alike(before, now, channels);
  require_beside(before, motion, 2);
  require_beside(before, object_before, 1);
  require_beside(before, object_now, 1);
  std::vector<float> map(now.pixel_count(), kNoValue);
  for (int y = 0; y < now.height; ++y)
    for (int x = 0; x < now.width; ++x) {
      const float id = object_now.at(x, y, 0);
      if (!(id != 0.0f)) continue;
      const double from_x = x - static_cast<double>(motion.at(x, y, 0));
      const double from_y = y - static_cast<double>(motion.at(x, y, 1));
      if (!(from_x >= 0.0 && from_y >= 0.0 && from_x <= now.width - 1.0 &&
            from_y <= now.height - 1.0))
        continue;
      const int x0 = std::min(static_cast<int>(from_x), std::max(0, now.width - 2));
      const int y0 = std::min(static_cast<int>(from_y), std::max(0, now.height - 2));
      const int x1 = std::min(x0 + 1, now.width - 1), y1 = std::min(y0 + 1, now.height - 1);
      if (object_before.at(x0, y0, 0) != id || object_before.at(x1, y0, 0) != id ||
          object_before.at(x0, y1, 0) != id || object_before.at(x1, y1, 0) != id)
        continue;
      const double u = from_x - x0, v = from_y - y0;
      double sum = 0.0;
      for (int c = 0; c < channels; ++c) {
        const double top = (1.0 - u) * before.at(x0, y0, c) + u * before.at(x1, y0, c);
        const double bottom = (1.0 - u) * before.at(x0, y1, c) + u * before.at(x1, y1, c);
        sum += std::abs(now.at(x, y, c) - ((1.0 - v) * top + v * bottom));
      }
      map[static_cast<std::size_t>(y) * now.width + x] = static_cast<float>(sum / channels);
    }
  return statistics_of(map, now.width);
}

NoiseTest noise_test(const ImageView& a, const ImageView& variance_a, const ImageView& b,
                     const ImageView& variance_b, double significance, double least_variance) {
  require_alike(a, b, 1);
  const int channels = std::min(a.channels, b.channels);
  require_beside(a, variance_a, channels);
  require_beside(a, variance_b, channels);
  NoiseTest out;
  out.values = a.pixel_count() * static_cast<std::size_t>(channels);
  // Sidak: every one of n values passes together with probability 1 - significance.
  const double each = -std::expm1(std::log1p(-significance) / static_cast<double>(out.values));
  out.bound = normal_quantile(0.5 * each);
  std::size_t passed = 0;
  bool finite = true;
  for (int y = 0; y < a.height; ++y)
    for (int x = 0; x < a.width; ++x)
      for (int c = 0; c < channels; ++c) {
        const double variance = std::max<double>(variance_a.at(x, y, c), least_variance) +
                                std::max<double>(variance_b.at(x, y, c), least_variance);
        const double z =
            std::abs(static_cast<double>(a.at(x, y, c)) - b.at(x, y, c)) / std::sqrt(variance);
        finite = finite && std::isfinite(z);
        passed += z <= out.bound;
        if (z > out.largest) out.largest = z;
      }
  if (!finite) {
    out.largest = std::numeric_limits<double>::quiet_NaN();
    return out;
  }
  out.passed = static_cast<double>(passed) / static_cast<double>(out.values);
  out.alike = out.passed >= 0.9975;
  return out;
}

std::vector<double> robust_scores(std::span<const double> series, double least) {
  std::vector<double> finite;
  for (double v : series)
    if (std::isfinite(v)) finite.push_back(v);
  std::vector<double> score(series.size(), std::numeric_limits<double>::quiet_NaN());
  if (finite.empty()) return score;
  std::vector<double> work = finite;
  const double median = quantile(work, 0.5);
  for (std::size_t i = 0; i < finite.size(); ++i) work[i] = std::abs(finite[i] - median);
  const double spread = std::max(1.4826 * quantile(work, 0.5), least);
  for (std::size_t i = 0; i < series.size(); ++i) score[i] = (series[i] - median) / spread;
  return score;
}

}  // namespace backbend::validate
