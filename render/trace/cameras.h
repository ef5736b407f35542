#pragma once
#include <glm/vec3.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "render/trace/scene.h"

namespace backbend::render {

/// An axis-aligned box, world space. Empty until something was added.
struct Bounds {
  glm::dvec3 low{1e300}, high{-1e300};

  bool is_empty() const { return !(low.x <= high.x); }
  void add(const glm::dvec3& point);
  void add(const Bounds& other);
};

/// Bounds of vertex positions.
Bounds bounds_of(std::span<const glm::vec3> position);

/// Which way a character stands: unit, world space, orthogonal.
struct Facing {
  glm::dvec3 up{0, 1, 0}, forward{0, 0, 1};
  glm::dvec3 left() const;  // up x forward
};

/// Names that view_camera() knows, the default first:
/// profile (seen from the character's left, where a backbend shows), front, back, three_quarter
/// (from behind its left shoulder).
std::span<const std::string_view> view_names();

/// A camera that holds all of `box` at `aspect` (width / height), a 50 mm lens on a 36 mm film
/// back. Give the box over all poses and both sides of a comparison, and every frame of it is
/// framed alike. Throws RenderError for an unknown view (naming the nearest), an empty box, a bad
/// aspect.
Camera view_camera(std::string_view view, const Bounds& box, const Facing& facing, double aspect);

/// A camera on `point` that holds a ball of `radius` around it, seen from the side of `view`.
Camera close_up(std::string_view view, const glm::dvec3& point, double radius, const Facing& facing,
                double aspect);

/// `views` cameras on a circle around the middle of the box, all at one height and distance: the
/// first from the front, then towards the character's left; the step after the last is the first.
std::vector<Camera> turntable(int views, const Bounds& box, const Facing& facing, double aspect);

}  // namespace backbend::render
