#pragma once
#include <glm/vec3.hpp>
#include <vector>

namespace backbend::render {

/// What contour lines are found from: one entry per pixel, top row first.
struct ContourInput {
  int width, height;
  std::vector<float> depth;       // along the view axis; kBackgroundDepth where nothing is
  std::vector<glm::vec3> normal;  // unit, world space
  std::vector<float> region;      // 0 where nothing is
};

/// Ink per pixel, 0..1: full on outlines and where one part hides another, less on creases and on
/// the borders of body regions. Depth steps are compared with the surface's own slope, so that a
/// surface seen edge-on is not a contour.
std::vector<float> find_contours(const ContourInput& in);

}  // namespace backbend::render
