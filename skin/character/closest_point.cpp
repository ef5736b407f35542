#include "skin/character/closest_point.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace backbend::skin {
namespace {

/// The point of an edge between two corners, as shares of the triangle's three.
TrianglePoint on_edge(const glm::dvec3& p, const std::array<glm::dvec3, 3>& corner, std::size_t i,
                      std::size_t k) {
  const glm::dvec3 edge = corner[k] - corner[i];
  const double squared = glm::dot(edge, edge);
  const double t =
      squared > 0.0 ? std::clamp(glm::dot(p - corner[i], edge) / squared, 0.0, 1.0) : 0.0;
  TrianglePoint out;
  out.share[i] = 1.0 - t;
  out.share[k] = t;
  out.distance = glm::distance(p, corner[i] + t * edge);
  return out;
}

}  // namespace

TrianglePoint closest_on_triangle(const glm::dvec3& p, const glm::dvec3& a, const glm::dvec3& b,
                                  const glm::dvec3& c) {
  const std::array<glm::dvec3, 3> corner = {a, b, c};
  const glm::dvec3 normal = glm::cross(b - a, c - a);
  const double squared = glm::dot(normal, normal);
  if (squared > 0.0) {
    TrianglePoint inside;
    for (std::size_t i = 0; i < 3; ++i) {
      const glm::dvec3& from = corner[(i + 1) % 3];
      const glm::dvec3& to = corner[(i + 2) % 3];
      inside.share[i] = glm::dot(glm::cross(to - from, p - from), normal) / squared;
    }
    if (*std::min_element(inside.share.begin(), inside.share.end()) >= 0.0) {
      inside.distance = std::abs(glm::dot(p - a, normal)) / glm::length(normal);
      return inside;
    }
  }
  TrianglePoint best = on_edge(p, corner, 0, 1);
  for (const auto& [i, k] : {std::pair<std::size_t, std::size_t>{1, 2}, {2, 0}})
    if (const TrianglePoint other = on_edge(p, corner, i, k); other.distance < best.distance)
      best = other;
  return best;
}

double distance_to_segment(const glm::dvec3& p, const glm::dvec3& a, const glm::dvec3& b) {
  const glm::dvec3 way = b - a;
  const double squared = glm::dot(way, way);
  const double t = squared > 0.0 ? std::clamp(glm::dot(p - a, way) / squared, 0.0, 1.0) : 0.0;
  return glm::distance(p, a + t * way);
}

}  // namespace backbend::skin
