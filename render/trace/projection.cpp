#include "render/trace/projection.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_access.hpp>

namespace backbend::render {
namespace {

bool is_finite(const glm::dvec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

}  // namespace

Projection project_camera(const Camera& camera, int width, int height) {
  if (width < 1 || height < 1 || width > 32768 || height > 32768)
    throw RenderError("image size " + std::to_string(width) + " x " + std::to_string(height) +
                      " is outside 1..32768");
  if (!is_finite(camera.eye) || !is_finite(camera.target) || !is_finite(camera.up))
    throw RenderError("camera: eye, target or up is not finite");
  if (!(camera.focal_mm > 0.0) || !(camera.film_width_mm > 0.0) ||
      !std::isfinite(camera.focal_mm) || !std::isfinite(camera.film_width_mm))
    throw RenderError("camera: focal length and film width must be positive");
  const glm::dvec3 view = camera.target - camera.eye;
  const double distance = glm::length(view);
  const glm::dvec3 side = glm::cross(view, camera.up);
  // Below this sine the horizon is decided by rounding.
  if (!(distance > 0.0) || !(glm::length(side) > 1e-9 * distance * glm::length(camera.up)))
    throw RenderError("camera: the eye is on the target, or up lies along the view axis");
  Projection p;
  p.eye = camera.eye;
  p.forward = view / distance;
  p.right = glm::normalize(side);
  p.up = glm::cross(p.right, p.forward);
  p.width = width;
  p.height = height;
  p.tan_x = 0.5 * camera.film_width_mm / camera.focal_mm;
  p.tan_y = p.tan_x * height / width;
  return p;
}

glm::dvec3 Projection::project(const glm::dvec3& world) const {
  const glm::dvec3 offset = world - eye;
  const double depth = glm::dot(offset, forward);
  const double x = glm::dot(offset, right) / (depth * tan_x);
  const double y = glm::dot(offset, up) / (depth * tan_y);
  return {0.5 * (x + 1.0) * width, 0.5 * (1.0 - y) * height, depth};
}

glm::dmat4 Projection::camera_from_world() const {
  glm::dmat4 m(1.0);
  m = glm::row(m, 0, glm::dvec4(right, -glm::dot(right, eye)));
  m = glm::row(m, 1, glm::dvec4(up, -glm::dot(up, eye)));
  m = glm::row(m, 2, glm::dvec4(-forward, glm::dot(forward, eye)));
  return m;
}

glm::dmat4 Projection::ndc_from_world() const {
  // x/w = (right . offset / (depth tan_x) + 1) / 2 with w = depth; y likewise, downwards.
  const glm::dvec4 depth(forward, -glm::dot(forward, eye));
  const glm::dvec4 across(right / tan_x, -glm::dot(right, eye) / tan_x);
  const glm::dvec4 upward(up / tan_y, -glm::dot(up, eye) / tan_y);
  glm::dmat4 m(1.0);
  m = glm::row(m, 0, 0.5 * (across + depth));
  m = glm::row(m, 1, 0.5 * (depth - upward));
  m = glm::row(m, 2, glm::dvec4(0.0, 0.0, 0.0, 1.0));  // z/w = 1/depth keeps the matrix invertible
  m = glm::row(m, 3, depth);
  return m;
}

}  // namespace backbend::render
