#include "validate/compare/surface_match.h"

#include <cmath>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <unordered_map>
#include <vector>

namespace backbend::validate {
namespace {

/// A point counts as found within this share of the height.
constexpr float kSameVertex = 0.005f;

/// The cloud about its middle, one high; empty where it has no height.
std::vector<glm::vec3> standardised(std::span<const glm::vec3> points) {
  if (points.empty()) return {};
  glm::vec3 low = points.front(), high = low;
  for (const glm::vec3& p : points) {
    low = glm::min(low, p);
    high = glm::max(high, p);
  }
  const float height = high.y - low.y;
  if (!(height > 0.0f) || !std::isfinite(height)) return {};
  std::vector<glm::vec3> result;
  result.reserve(points.size());
  for (const glm::vec3& p : points) result.push_back((p - 0.5f * (low + high)) / height);
  return result;
}

/// Cells as wide as "near" reaches, so that a neighbour lies in one of 27.
struct Cell {
  std::int32_t x, y, z;

  explicit Cell(const glm::vec3& p)
      : x(static_cast<std::int32_t>(std::floor(p.x / kSameVertex))),
        y(static_cast<std::int32_t>(std::floor(p.y / kSameVertex))),
        z(static_cast<std::int32_t>(std::floor(p.z / kSameVertex))) {}
  std::uint64_t key(int dx, int dy, int dz) const {
    const auto part = [](std::int32_t v) { return static_cast<std::uint64_t>(v & 0x1fffff); };
    return part(x + dx) << 42 | part(y + dy) << 21 | part(z + dz);
  }
};

}  // namespace

double surface_match(std::span<const glm::vec3> a, std::span<const glm::vec3> b) {
  const std::vector<glm::vec3> there = standardised(a), wanted = standardised(b);
  if (there.empty() || wanted.empty()) return std::numeric_limits<double>::quiet_NaN();
  std::unordered_map<std::uint64_t, std::vector<std::size_t>> cells;
  for (std::size_t i = 0; i < there.size(); ++i) cells[Cell(there[i]).key(0, 0, 0)].push_back(i);
  std::size_t found = 0;
  for (const glm::vec3& p : wanted) {
    const Cell cell(p);
    bool near = false;
    for (int n = 0; n < 27 && !near; ++n) {
      const auto held = cells.find(cell.key(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1));
      if (held == cells.end()) continue;
      for (const std::size_t i : held->second)
        near = near || glm::distance(there[i], p) <= kSameVertex;
    }
    found += near ? 1 : 0;
  }
  return static_cast<double>(found) / static_cast<double>(wanted.size());
}

}  // namespace backbend::validate
