#include "render/trace/overlay.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace backbend::render {
namespace {

struct FilmLine {
  glm::dvec2 from, to;
};

// The part of a line in front of the camera, on the film; false where there is none.
bool project_line(const OverlayLine& line, const Projection& projection, FilmLine& out) {
  glm::dvec3 from(line.from), to(line.to);
  const double depth_from = glm::dot(from - projection.eye, projection.forward);
  const double depth_to = glm::dot(to - projection.eye, projection.forward);
  const double nearest = 1e-3 * std::max(std::abs(depth_from), std::abs(depth_to));
  if (!(std::max(depth_from, depth_to) > nearest) || !(nearest > 0.0)) return false;
  const glm::dvec3 cut = from + (to - from) * ((nearest - depth_from) / (depth_to - depth_from));
  if (depth_from < nearest) from = cut;
  if (depth_to < nearest) to = cut;
  out = {glm::dvec2(projection.project(from)), glm::dvec2(projection.project(to))};
  return true;
}

// Where along a segment the nearest point to `at` lies, and how far away that is.
double distance_to(const FilmLine& line, const glm::dvec2& at) {
  const glm::dvec2 along = line.to - line.from;
  const double length2 = glm::dot(along, along);
  const double t =
      length2 > 0.0 ? std::clamp(glm::dot(at - line.from, along) / length2, 0.0, 1.0) : 0.0;
  return glm::length(at - line.from - along * t);
}

}  // namespace

void draw_overlay(std::span<const OverlayLine> lines, const Projection& projection, Frame& frame) {
  float* beauty = nullptr;
  for (Layer& layer : frame.layers)
    if (layer.names.front() == "R" && layer.names.size() == 4) beauty = layer.data.data();
  if (!beauty) return;
  for (const OverlayLine& line : lines) {
    FilmLine film;
    if (!project_line(line, projection, film)) continue;
    const double half = 0.5 * std::max(0.0f, line.width_px);
    const double reach = half + 1.0;
    const auto first = [&](double a, double b, int size) {
      return static_cast<int>(std::floor(std::clamp(std::min(a, b) - reach, 0.0, double(size))));
    };
    const auto last = [&](double a, double b, int size) {
      return static_cast<int>(std::ceil(std::clamp(std::max(a, b) + reach, 0.0, double(size))));
    };
    const int x0 = first(film.from.x, film.to.x, frame.width);
    const int x1 = last(film.from.x, film.to.x, frame.width);
    const int y0 = first(film.from.y, film.to.y, frame.height);
    const int y1 = last(film.from.y, film.to.y, frame.height);
    for (int y = y0; y < y1; ++y) {
      for (int x = x0; x < x1; ++x) {
        const double distance = distance_to(film, {x + 0.5, y + 0.5});
        const auto cover = static_cast<float>(std::clamp(half + 0.5 - distance, 0.0, 1.0));
        if (cover <= 0.0f) continue;
        float* pixel = beauty + (static_cast<std::size_t>(y) * frame.width + x) * 4;
        for (int c = 0; c < 3; ++c) pixel[c] += (line.color[c] - pixel[c]) * cover;
        pixel[3] += (1.0f - pixel[3]) * cover;
      }
    }
  }
}

}  // namespace backbend::render
