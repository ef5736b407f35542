#pragma once
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

namespace backbend::validate {

/// A posed mesh as the report page reads it, small enough to travel inside the page: positions in
/// 16 bits of their bounding box (a 2 m figure is good to 0.02 mm), heat in 8 bits.

/// One pose. `position` [vertices] in metres, +Y up; `heat` [vertices] or empty; heat_low to
/// heat_high is the scale's range. A heat that is not finite is shown as not measured; a position
/// that is not finite is drawn at the box's lower corner.
std::vector<std::uint8_t> encode_mesh_pose(std::span<const glm::vec3> position,
                                           std::span<const float> heat, float heat_low,
                                           float heat_high);

/// The triangles of all poses of one mesh. Every index must be below `vertex_count`.
std::vector<std::uint8_t> encode_mesh_triangles(std::span<const glm::uvec3> triangle,
                                                std::uint32_t vertex_count);

}  // namespace backbend::validate
