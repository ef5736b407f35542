#include "render/trace/environment_map.h"

#include <algorithm>
#include <cmath>

#include "render/trace/pi.h"

namespace backbend::render {
namespace {

// The step of a rising staircase from 0 to 1 that `at` falls on: [0, steps).
std::size_t find_step(const float* cdf, std::size_t steps, float at) {
  const float* above = std::upper_bound(cdf, cdf + steps + 1, at);
  const auto step = static_cast<std::size_t>(above - cdf);
  return std::clamp<std::size_t>(step, 1, steps) - 1;
}

}  // namespace

EnvironmentMap::EnvironmentMap(Texture picture, double turn_rad)
    : picture_(std::move(picture)), turn_(static_cast<float>(turn_rad)) {
  const auto width = static_cast<std::size_t>(std::max(picture_.width, 0));
  const auto height = static_cast<std::size_t>(std::max(picture_.height, 0));
  if (width == 0 || height == 0 || picture_.texel.size() != width * height)
    throw RenderError("environment: the picture is empty");
  std::vector<double> row_sum(height, 0.0);
  column_cdf_.resize(height * (width + 1));
  double total = 0.0;
  for (std::size_t y = 0; y < height; ++y) {
    // Rows near the poles cover less of the sphere.
    const double sine = std::sin(std::numbers::pi * (static_cast<double>(y) + 0.5) / height);
    double sum = 0.0;
    std::vector<double> running(width + 1, 0.0);
    for (std::size_t x = 0; x < width; ++x) {
      const glm::vec4& t = picture_.texel[y * width + x];
      if (!(t.x >= 0.0f && t.y >= 0.0f && t.z >= 0.0f) || !std::isfinite(t.x + t.y + t.z))
        throw RenderError("environment: texel " + std::to_string(x) + ", " + std::to_string(y) +
                          " is negative or not finite");
      sum += 0.2126 * t.x + 0.7152 * t.y + 0.0722 * t.z;
      running[x + 1] = sum;
    }
    for (std::size_t x = 0; x <= width; ++x)
      column_cdf_[y * (width + 1) + x] = static_cast<float>(
          sum > 0.0 ? running[x] / sum : static_cast<double>(x) / static_cast<double>(width));
    row_sum[y] = sum * sine;
    total += row_sum[y];
  }
  if (!(total > 0.0)) throw RenderError("environment: the picture is black");
  row_cdf_.assign(1, 0.0f);
  double running = 0.0;
  for (const double sum : row_sum) row_cdf_.push_back(static_cast<float>((running += sum) / total));
  row_cdf_.back() = 1.0f;
}

std::size_t EnvironmentMap::texel_of(const glm::vec3& direction) const {
  const float around = 0.5f - (std::atan2(direction.x, direction.z) - turn_) / (2.0f * kPi);
  const float u = around - std::floor(around);
  const float v = std::acos(std::clamp(direction.y, -1.0f, 1.0f)) / kPi;
  const int x =
      std::clamp(static_cast<int>(u * static_cast<float>(picture_.width)), 0, picture_.width - 1);
  const int y =
      std::clamp(static_cast<int>(v * static_cast<float>(picture_.height)), 0, picture_.height - 1);
  return static_cast<std::size_t>(y) * picture_.width + x;
}

glm::vec3 EnvironmentMap::radiance(const glm::vec3& direction) const {
  return picture_.texel[texel_of(direction)];
}

float EnvironmentMap::pdf(const glm::vec3& direction) const {
  const std::size_t texel = texel_of(direction);
  const auto width = static_cast<std::size_t>(picture_.width);
  const std::size_t y = texel / width, x = texel % width;
  const float* column = column_cdf_.data() + y * (width + 1);
  const float share = (row_cdf_[y + 1] - row_cdf_[y]) * (column[x + 1] - column[x]);
  // A texel spans 2 pi / width by pi / height in angle, and its solid angle shrinks with the sine.
  const float sine = std::sqrt(std::max(0.0f, 1.0f - direction.y * direction.y));
  const float solid_angle = 2.0f * kPi * kPi * sine / static_cast<float>(picture_.texel.size());
  return solid_angle > 0.0f ? share / solid_angle : 0.0f;
}

EnvironmentMap::Sample EnvironmentMap::sample(glm::vec2 random) const {
  const auto width = static_cast<std::size_t>(picture_.width);
  const auto height = static_cast<std::size_t>(picture_.height);
  const std::size_t y = find_step(row_cdf_.data(), height, random.y);
  const float* column = column_cdf_.data() + y * (width + 1);
  const std::size_t x = find_step(column, width, random.x);
  const auto within = [](float at, float low, float high) {
    return high > low ? std::clamp((at - low) / (high - low), 0.0f, 0.999999f) : 0.5f;
  };
  const float u = (static_cast<float>(x) + within(random.x, column[x], column[x + 1])) / width;
  const float v = (static_cast<float>(y) + within(random.y, row_cdf_[y], row_cdf_[y + 1])) / height;
  const float longitude = (0.5f - u) * 2.0f * kPi + turn_;
  const float sine = std::sin(v * kPi);
  Sample s;
  s.direction = {sine * std::sin(longitude), std::cos(v * kPi), sine * std::cos(longitude)};
  s.radiance = picture_.texel[y * width + x];
  s.pdf = pdf(s.direction);
  return s;
}

}  // namespace backbend::render
