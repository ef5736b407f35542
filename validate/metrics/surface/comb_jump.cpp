#include "validate/metrics/surface/comb_jump.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <limits>

namespace backbend::validate {
namespace {

constexpr std::array<std::size_t, 2> kMidLines = {kLineCount / 4, 3 * kLineCount / 4};

/// The rotation vector of the least turn from one direction to another.
glm::dvec3 turn_between(const glm::dvec3& from, const glm::dvec3& to) {
  const glm::dvec3 axis = glm::cross(from, to);
  const double sine = glm::length(axis);
  return sine > 0.0 ? axis * (std::atan2(sine, glm::dot(from, to)) / sine) : glm::dvec3(0.0);
}

/// The jump between the two teeth over four points that follow each other along a line, radians.
double jump_of(const std::array<glm::dvec3, 4>& point) {
  const glm::dvec3 below = point[1] - point[0], middle = point[2] - point[1],
                   above = point[3] - point[2];
  return glm::length(turn_between(middle, above) - turn_between(below, middle));
}

}  // namespace

CombJump comb_jump(const SpineSlices& slices, const SlicePose& rest, const SlicePose& pose,
                   int window) {
  CombJump worst{std::numeric_limits<double>::quiet_NaN(), -1};
  const std::size_t count = slices.slice.size(), step = static_cast<std::size_t>(window);
  for (const std::size_t line : kMidLines) {
    const auto is_on_line = [&](std::size_t s) {
      const Slice& slice = slices.slice[s];
      return line < slice.line.size() && slice.line[line].surface &&
             slice.spine_share >= kSpineSlice;
    };
    const auto points = [&](const SlicePose& of, std::size_t first) {
      std::array<glm::dvec3, 4> out{};
      for (std::size_t k = 0; k < out.size(); ++k)
        out[k] = of.line[(first + k * step) * kLineCount + line];
      return out;
    };
    for (std::size_t s = 0; s + 3 * step < count; ++s) {
      if (!is_on_line(s) || !is_on_line(s + step) || !is_on_line(s + 2 * step) ||
          !is_on_line(s + 3 * step))
        continue;
      const double angle =
          glm::degrees(std::max(0.0, jump_of(points(pose, s)) - jump_of(points(rest, s))));
      if (angle <= worst.angle_deg) continue;
      worst = {angle, static_cast<int>(s + 3 * step / 2)};
    }
  }
  return worst;
}

}  // namespace backbend::validate
