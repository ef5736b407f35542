#pragma once
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <string>
#include <vector>

namespace backbend::validate {

/// How a point cache's space differs from the body's: caches name neither their unit nor their up.
struct PointSpace {
  double scale = 1.0;    // the body's lengths over the cache's
  glm::dmat3 turn{1.0};  // from the cache's axes to the body's
  std::string note;      // what was taken, for a person; empty: nothing differs
  glm::vec3 to_body(const glm::vec3& point) const {
    return glm::vec3(scale * (turn * glm::dvec3(point)));
  }
  bool differs() const { return !note.empty(); }
};

/// The spaces that a cache may be in, the body's own first: +Y or +Z up, in the units that programs
/// write (metres, centimetres, millimetres, inches, decimetres), each way round.
const std::vector<PointSpace>& point_spaces();

/// The space of a frame whose points are the body's vertices, in order: the unit nearest to
/// `length_ratio` (the frame's edges over those at rest, any pose) and the up that lies nearest to
/// how the points are turned. The body's own where no unit is within a quarter of the ratio.
const PointSpace& space_in_order(std::span<const glm::vec3> rest, std::span<const glm::vec3> frame,
                                 double length_ratio);

}  // namespace backbend::validate
