#include "render/trace/cameras.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

namespace backbend::render {
namespace {

struct View {
  std::string_view name;
  double azimuth_deg;    // from the front towards the character's left
  double elevation_deg;  // of the camera above its middle
};
constexpr std::array kViews{View{"profile", 90.0, 4.0}, View{"front", 0.0, 4.0},
                            View{"back", 180.0, 4.0}, View{"three_quarter", 145.0, 12.0}};
constexpr double kTurntableElevation = 6.0;
constexpr double kMargin = 1.08;  // of the figure's size, so that nothing touches the frame's edge

std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0]++;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t substitute = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({row[j] + 1, row[j + 1] + 1, substitute});
    }
  }
  return row.back();
}

const View& find_view(std::string_view name) {
  const auto* nearest = &kViews[0];
  for (const View& view : kViews) {
    if (view.name == name) return view;
    if (edit_distance(name, view.name) < edit_distance(name, nearest->name)) nearest = &view;
  }
  throw RenderError("view '" + std::string(name.substr(0, 64)) + "' is unknown; did you mean '" +
                    std::string(nearest->name) + "'?");
}

glm::dvec3 direction(double azimuth_deg, double elevation_deg, const Facing& facing) {
  const double azimuth = azimuth_deg * std::numbers::pi / 180.0;
  const double elevation = elevation_deg * std::numbers::pi / 180.0;
  return std::cos(elevation) *
             (std::cos(azimuth) * facing.forward + std::sin(azimuth) * facing.left()) +
         std::sin(elevation) * facing.up;
}

void check(const Bounds& box, const Facing& facing, double aspect) {
  const double extent = glm::length(box.high - box.low);
  if (box.is_empty() || !std::isfinite(extent) || !(extent > 0.0))
    throw RenderError("camera: there is nothing to frame");
  if (!(aspect > 0.0) || !std::isfinite(aspect)) throw RenderError("camera: bad aspect ratio");
  if (!(std::abs(glm::length(facing.up) - 1.0) < 1e-6) ||
      !(std::abs(glm::length(facing.forward) - 1.0) < 1e-6) ||
      !(std::abs(glm::dot(facing.up, facing.forward)) < 1e-6))
    throw RenderError("camera: up and forward must be unit length and at right angles");
}

// Half the film's extents at unit depth.
glm::dvec2 half_film(const Camera& camera, double aspect) {
  const double x = 0.5 * camera.film_width_mm / camera.focal_mm;
  return {x, x / aspect};
}

// The nearest distance along unit `from` at which every corner of the box is inside the frame.
double fitting_distance(const Camera& camera, const Bounds& box, const glm::dvec3& from,
                        double aspect) {
  const glm::dvec3 right = glm::normalize(glm::cross(-from, camera.up));
  const glm::dvec3 up = glm::cross(right, -from);
  const glm::dvec2 film = half_film(camera, aspect);
  double distance = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    const glm::dvec3 point(corner & 1 ? box.high.x : box.low.x, corner & 2 ? box.high.y : box.low.y,
                           corner & 4 ? box.high.z : box.low.z);
    const glm::dvec3 offset = point - camera.target;
    const double across = std::max(std::abs(glm::dot(offset, right)) / film.x,
                                   std::abs(glm::dot(offset, up)) / film.y);
    distance = std::max(distance, kMargin * across + glm::dot(offset, from));
  }
  return distance;
}

Camera aim(const glm::dvec3& target, const glm::dvec3& from, double distance,
           const Facing& facing) {
  Camera camera;
  camera.target = target;
  camera.eye = target + from * distance;
  camera.up = facing.up;
  return camera;
}

}  // namespace

void Bounds::add(const glm::dvec3& point) {
  low = glm::min(low, point);
  high = glm::max(high, point);
}
void Bounds::add(const Bounds& other) {
  low = glm::min(low, other.low);
  high = glm::max(high, other.high);
}

Bounds bounds_of(std::span<const glm::vec3> position) {
  Bounds box;
  for (const glm::vec3& p : position) box.add(glm::dvec3(p));
  return box;
}

glm::dvec3 Facing::left() const { return glm::cross(up, forward); }

std::span<const std::string_view> view_names() {
  static constexpr std::array names{kViews[0].name, kViews[1].name, kViews[2].name, kViews[3].name};
  return names;
}

Camera view_camera(std::string_view name, const Bounds& box, const Facing& facing, double aspect) {
  check(box, facing, aspect);
  const View& view = find_view(name);
  const glm::dvec3 from = direction(view.azimuth_deg, view.elevation_deg, facing);
  const Camera toward = aim(0.5 * (box.low + box.high), from, 1.0, facing);
  return aim(toward.target, from, fitting_distance(toward, box, from, aspect), facing);
}

Camera close_up(std::string_view name, const glm::dvec3& point, double radius, const Facing& facing,
                double aspect) {
  if (!(radius > 0.0) || !std::isfinite(radius) || !std::isfinite(glm::dot(point, point)))
    throw RenderError("camera: a close-up needs a finite point and a positive radius");
  check({point - radius, point + radius}, facing, aspect);
  const View& view = find_view(name);
  const glm::dvec3 from = direction(view.azimuth_deg, view.elevation_deg, facing);
  const glm::dvec2 film = half_film(Camera{}, aspect);
  // A ball fills the frame where its tangent cone does: sin(half angle) = radius / distance.
  const double half_angle = std::atan(std::min(film.x, film.y));
  return aim(point, from, kMargin * radius / std::sin(half_angle), facing);
}

std::vector<Camera> turntable(int views, const Bounds& box, const Facing& facing, double aspect) {
  check(box, facing, aspect);
  if (views < 1) throw RenderError("camera: a turntable needs at least one view");
  const glm::dvec3 target = 0.5 * (box.low + box.high);
  std::vector<glm::dvec3> from;
  double distance = 0.0;
  for (int i = 0; i < views; ++i) {
    from.push_back(direction(360.0 * i / views, kTurntableElevation, facing));
    distance = std::max(distance, fitting_distance(aim(target, from.back(), 1.0, facing), box,
                                                   from.back(), aspect));
  }
  std::vector<Camera> cameras;
  for (const glm::dvec3& side : from) cameras.push_back(aim(target, side, distance, facing));
  return cameras;
}

}  // namespace backbend::render
