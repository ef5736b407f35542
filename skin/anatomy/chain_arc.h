#pragma once
#include <glm/vec3.hpp>
#include <span>

namespace backbend::skin {

/// Length of the polyline through the points.
double arc_length(std::span<const glm::dvec3> chain);

/// Where along the polyline, as arc length from its start, it passes closest to `point`; the first
/// such place where there are several. 0 for a chain of one point.
double nearest_arc(std::span<const glm::dvec3> chain, const glm::dvec3& point);

/// The point of the polyline at a fraction (0..1) of its length.
glm::dvec3 point_at(std::span<const glm::dvec3> chain, double fraction);

}  // namespace backbend::skin
