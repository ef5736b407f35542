#pragma once
#include <array>
#include <glm/vec3.hpp>
#include <vector>

namespace backbend::skin {

/// The half of a symmetric body with x >= 0: open along x = 0 exactly, closed everywhere else,
/// seen from outside anticlockwise.
struct HalfMesh {
  std::vector<glm::dvec3> position;
  std::vector<std::array<int, 3>> triangle;

  bool on_plane(int vertex) const { return position[static_cast<std::size_t>(vertex)].x == 0.0; }
};

}  // namespace backbend::skin
