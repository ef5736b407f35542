#include "validate/metrics/surface/surface_points.h"

#include <cmath>
#include <glm/geometric.hpp>

namespace backbend::validate {

using Index = std::size_t;

std::vector<glm::vec3> surface_normals(const skin::Character& character,
                                       std::span<const glm::vec3> position) {
  std::vector<glm::dvec3> sum(character.place_count, glm::dvec3(0.0));
  for (const glm::uvec3& triangle : character.triangles) {
    const glm::dvec3 a(position[triangle.x]), b(position[triangle.y]), c(position[triangle.z]);
    const glm::dvec3 area = glm::cross(b - a, c - a);
    for (const std::uint32_t v : {triangle.x, triangle.y, triangle.z})
      sum[character.place[v]] += area;
  }
  std::vector<glm::vec3> out;
  for (Index v = 0; v < position.size(); ++v) {
    const glm::dvec3& n = sum[character.place[v]];
    const double length = glm::length(n);
    out.emplace_back(length > 0.0 ? n / length : glm::dvec3(0, 1, 0));
  }
  return out;
}

PointGrid::PointGrid(std::span<const glm::vec3> point, double cell) : point_(point), cell_(cell) {
  for (Index i = 0; i < point.size(); ++i) cells_[key(point[i])].push_back(i);
}

std::ptrdiff_t PointGrid::nearest(const glm::vec3& place) const {
  std::ptrdiff_t best = -1;
  double least = cell_ * cell_;
  const glm::dvec3 p(place);
  for (int dx = -1; dx <= 1; ++dx)
    for (int dy = -1; dy <= 1; ++dy)
      for (int dz = -1; dz <= 1; ++dz) {
        const auto found = cells_.find(key(p + cell_ * glm::dvec3(dx, dy, dz)));
        if (found == cells_.end()) continue;
        for (const Index i : found->second) {
          const glm::dvec3 way = glm::dvec3(point_[i]) - p;
          const double squared = glm::dot(way, way);
          const bool first = best < 0 || static_cast<Index>(best) > i;
          if (squared < least || (squared == least && first)) {
            least = squared;
            best = static_cast<std::ptrdiff_t>(i);
          }
        }
      }
  return best;
}

std::uint64_t PointGrid::key(const glm::dvec3& p) const {
  std::uint64_t out = 0;
  for (int c = 0; c < 3; ++c) {  // 21 bits a coordinate: a body spans a thousand cells
    // Points beyond the range of integers share the last cell.
    const double cell = std::fmin(std::fmax(std::floor(p[c] / cell_), -1e15), 1e15);
    out = out << 21 | (static_cast<std::uint64_t>(static_cast<std::int64_t>(cell)) & 0x1FFFFF);
  }
  return out;
}

}  // namespace backbend::validate
