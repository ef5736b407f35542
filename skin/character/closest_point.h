#pragma once
#include <array>
#include <glm/vec3.hpp>

namespace backbend::skin {

/// A point of a triangle, by the share of each corner (0..1, sum 1).
struct TrianglePoint {
  std::array<double, 3> share{};
  double distance = 0.0;  // from what was asked for
};

/// The point of the triangle a, b, c nearest to `p`. Of a triangle without area, the nearest point
/// of its edges.
TrianglePoint closest_on_triangle(const glm::dvec3& p, const glm::dvec3& a, const glm::dvec3& b,
                                  const glm::dvec3& c);

/// The distance from `p` to the segment from `a` to `b`, which may have no length.
double distance_to_segment(const glm::dvec3& p, const glm::dvec3& a, const glm::dvec3& b);

}  // namespace backbend::skin
