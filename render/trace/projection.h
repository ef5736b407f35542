#pragma once
#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "render/image/lanes.h"
#include "render/trace/scene.h"

namespace backbend::render {

/// A camera prepared for one image size. The film's width is kept; its height follows the pixels,
/// which are square.
struct Projection {
  glm::dvec3 eye, right, up, forward;  // world space; the axes are orthonormal
  double tan_x, tan_y;                 // half extents of the image at unit depth
  int width, height;

  /// Directions through film positions (0..width, 0..height; the top row first), scaled so that
  /// their component along the view axis is 1: a hit at t lies at depth t.
  Vec8 directions(Float8 film_x, Float8 film_y) const {
    const auto wide = static_cast<float>(tan_x), tall = static_cast<float>(tan_y);
    const Float8 x = (film_x * (2.0f / static_cast<float>(width)) - 1.0f) * wide;
    const Float8 y = (1.0f - film_y * (2.0f / static_cast<float>(height))) * tall;
    return splat(glm::vec3(forward)) + splat(glm::vec3(right)) * x + splat(glm::vec3(up)) * y;
  }
  /// Where a world point lands on the film, in pixels; its depth is the third component, and the
  /// first two mean nothing unless it is positive.
  glm::dvec3 project(const glm::dvec3& world) const;

  glm::dmat4 camera_from_world() const;  // right-handed, -z forward
  glm::dmat4 ndc_from_world() const;     // x, y in 0..1 from the upper left, after division by w
};

/// Throws RenderError for a camera that sees nothing: eye on the target, up along the view axis,
/// sizes that are not positive, anything not finite.
Projection project_camera(const Camera& camera, int width, int height);

}  // namespace backbend::render
