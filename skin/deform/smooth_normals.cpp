#include "skin/deform/smooth_normals.h"

#include <algorithm>
#include <glm/geometric.hpp>

#include "skin/character/weld.h"

namespace backbend::skin {

bool fill_missing_normals(Character& character, const Part& part, bool mirrored) {
  if (part.vertex_count == 0) return false;
  const auto normal = character.bind_normal.begin() + part.first_vertex;
  const auto is_missing = [](const glm::vec3& n) { return !(glm::dot(n, n) > 1e-12f); };
  if (std::none_of(normal, normal + part.vertex_count, is_missing)) return false;

  const Places places =
      weld({character.bind_position.data() + part.first_vertex, part.vertex_count});
  std::vector<glm::dvec3> sum(places.count, glm::dvec3(0.0));
  for (std::uint32_t t = 0; t < part.triangle_count; ++t) {
    const glm::uvec3 triangle = character.triangles[part.first_triangle + t];
    glm::dvec3 corner[3];
    for (int k = 0; k < 3; ++k) corner[k] = character.bind_position[triangle[k]];
    glm::dvec3 area = glm::cross(corner[1] - corner[0], corner[2] - corner[0]);
    if (mirrored) area = -area;
    for (int k = 0; k < 3; ++k) sum[places.place[triangle[k] - part.first_vertex]] += area;
  }
  for (std::uint32_t v = 0; v < part.vertex_count; ++v) {
    if (!is_missing(normal[v])) continue;
    const glm::dvec3 total = sum[places.place[v]];
    const double length = glm::length(total);
    normal[v] = length > 0.0 ? glm::vec3(total / length) : glm::vec3(0.0f, 1.0f, 0.0f);
  }
  return true;
}

}  // namespace backbend::skin
