#include "render/trace/wire.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace backbend::render {
namespace {

constexpr float kFullHeight = 6.0f;  // pixels: a triangle at least as tall draws full lines

float distance_to_segment(glm::vec2 at, glm::vec2 from, glm::vec2 to) {
  const glm::vec2 along = to - from;
  const float length2 = glm::dot(along, along);
  const float t =
      length2 > 0.0f ? std::clamp(glm::dot(at - from, along) / length2, 0.0f, 1.0f) : 0.0f;
  return glm::length(at - from - along * t);
}

}  // namespace

float wire_coverage(const SceneView& scene, const Projection& projection, std::uint32_t triangle,
                    glm::vec2 film) {
  const glm::uvec3 v = scene.mesh->triangle[triangle];
  glm::vec2 corner[3];
  for (int i = 0; i < 3; ++i) {
    const glm::dvec3 p = projection.project(scene.pose.position[v[i]]);
    if (!(p.z > 0.0)) return 0.0f;
    corner[i] = glm::vec2(p);
  }
  const float distance = std::min({distance_to_segment(film, corner[0], corner[1]),
                                   distance_to_segment(film, corner[1], corner[2]),
                                   distance_to_segment(film, corner[2], corner[0])});
  // Where triangles shrink towards a pixel their lines would fill the surface: they fade instead.
  const float area = 0.5f * std::abs((corner[1].x - corner[0].x) * (corner[2].y - corner[0].y) -
                                     (corner[2].x - corner[0].x) * (corner[1].y - corner[0].y));
  const float longest =
      std::max({glm::length(corner[1] - corner[0]), glm::length(corner[2] - corner[1]),
                glm::length(corner[0] - corner[2]), 1e-3f});
  const float presence = std::clamp(2.0f * area / longest / kFullHeight, 0.15f, 1.0f);
  constexpr float kHalfWidth = 0.45f;  // pixels; every triangle draws its own half of a shared edge
  return presence * std::clamp(kHalfWidth + 0.5f - distance, 0.0f, 1.0f);
}

}  // namespace backbend::render
