#pragma once
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

namespace backbend::skin {

/// Which vertices stand at exactly one point.
struct Places {
  std::vector<std::uint32_t> place;  // per vertex, 0 .. count-1, numbered by first appearance
  std::uint32_t count = 0;
};

/// Numbers the distinct points; equal means equal in every coordinate (-0 equals 0). Any
/// topological question about a mesh with split normals or seams must be asked of places.
Places weld(std::span<const glm::vec3> point);

}  // namespace backbend::skin
