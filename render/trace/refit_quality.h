#pragma once
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

namespace backbend::render {

/// How well a tree that was built in the rest pose still fits another pose.
///
/// Triangles that were neighbours at rest share the tree's lower boxes. Those boxes are stood in
/// for by groups of 32 triangles along a Morton curve through the rest pose. What a ray pays is in
/// proportion to a box's surface, so quality is the surface of the groups' boxes over that of their
/// triangles' own boxes, against the same at rest (of a thousand groups or more; smaller meshes, of
/// all): it does not change where a pose is moved or
/// scaled, grows where neighbours are torn apart, and depends on this pose and the rest pose alone.
class RefitQuality {
 public:
  /// `triangle` must outlive this. Needs every index to be below rest_position.size().
  RefitQuality(std::span<const glm::uvec3> triangle, std::span<const glm::vec3> rest_position);

  /// 1 at rest; 2 where groups are twice as wide-meshed. 1 where nothing has any extent.
  double growth(std::span<const glm::vec3> position) const;

 private:
  double looseness(std::span<const glm::vec3> position) const;

  std::span<const glm::uvec3> triangle_;
  std::vector<std::uint32_t> order_;  // triangles, group after group
  double rest_looseness_ = 0.0;
};

}  // namespace backbend::render
