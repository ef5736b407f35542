#pragma once
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <unordered_map>
#include <vector>

#include "skin/character/character.h"

namespace backbend::validate {

/// Area-weighted normals of a posed surface of the character, one for all vertices of a place.
std::vector<glm::vec3> surface_normals(const skin::Character& character,
                                       std::span<const glm::vec3> position);

/// Points in a grid of cubes, to find those near a place. Keeps a view of the points.
class PointGrid {
 public:
  PointGrid(std::span<const glm::vec3> point, double cell);
  /// The nearest point within one cell's width, -1 for none; of equally near ones the first.
  std::ptrdiff_t nearest(const glm::vec3& place) const;

 private:
  std::uint64_t key(const glm::dvec3& p) const;
  std::span<const glm::vec3> point_;
  double cell_;
  std::unordered_map<std::uint64_t, std::vector<std::size_t>> cells_;
};

}  // namespace backbend::validate
