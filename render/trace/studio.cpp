#include "render/trace/studio.h"

#include <cmath>
#include <glm/geometric.hpp>

#include "render/trace/pi.h"

namespace backbend::render {
namespace {

struct Placement {
  float azimuth_deg;     // about the vertical, from the camera's side of the character to its left
  float elevation_deg;   // above the horizontal
  float distance;        // in character radii
  float size;            // edge of the square, in character radii
  glm::vec3 irradiance;  // on a surface at the centre that faces the light
};

// A photographer's three lights. The key is as wide as the character is tall for soft edges; the
// fill opens its shadows; the rim parts a grey body from the backdrop.
constexpr Placement kKey{52.0f, 46.0f, 3.4f, 1.9f, {2.55f, 2.48f, 2.36f}};
constexpr Placement kFill{-55.0f, 22.0f, 4.2f, 3.0f, {0.26f, 0.28f, 0.32f}};
constexpr Placement kRim{-150.0f, 50.0f, 3.8f, 1.6f, {1.30f, 1.33f, 1.38f}};

AreaLight place(const Placement& p, const glm::vec3& center, float radius, const glm::vec3& toward,
                const glm::vec3& left) {
  const float azimuth = p.azimuth_deg * kPi / 180.0f;
  const float elevation = p.elevation_deg * kPi / 180.0f;
  const glm::vec3 up(0.0f, 1.0f, 0.0f);
  const glm::vec3 from =
      std::cos(elevation) * (std::cos(azimuth) * toward + std::sin(azimuth) * left) +
      std::sin(elevation) * up;
  AreaLight light;
  light.center = center + from * (p.distance * radius);
  light.normal = -from;
  const glm::vec3 side = glm::normalize(glm::cross(up, from));
  light.half_u = side * (0.5f * p.size * radius);
  light.half_v = glm::cross(from, side) * (0.5f * p.size * radius);
  light.area = p.size * p.size * radius * radius;
  light.radiance = p.irradiance * (p.distance * p.distance / (p.size * p.size));
  light.extent = glm::length(light.half_u + light.half_v);
  light.power = light.area * (0.2126f * light.radiance.x + 0.7152f * light.radiance.y +
                              0.0722f * light.radiance.z);
  return light;
}

}  // namespace

Studio make_studio(const Projection& camera, const glm::vec3& center, float radius, float floor,
                   double turn_deg) {
  glm::vec3 toward(-camera.forward);
  toward.y = 0.0f;
  // Seen from straight above or below, the top of the image stands for "away from the camera".
  if (glm::length(toward) < 1e-3f) {
    toward = glm::vec3(-camera.up);
    toward.y = 0.0f;
  }
  toward = glm::normalize(toward);
  glm::vec3 left = glm::cross(toward, glm::vec3(0.0f, 1.0f, 0.0f));  // the camera's left
  const double turn = turn_deg * std::numbers::pi / 180.0;
  const auto cosine = static_cast<float>(std::cos(turn)), sine = static_cast<float>(std::sin(turn));
  const glm::vec3 facing = toward;
  toward = facing * cosine + left * sine;
  left = left * cosine - facing * sine;
  Studio studio;
  studio.light = {place(kKey, center, radius, toward, left),
                  place(kFill, center, radius, toward, left),
                  place(kRim, center, radius, toward, left)};
  studio.sky_zenith = {0.24f, 0.255f, 0.285f};
  studio.sky_horizon = {0.15f, 0.152f, 0.155f};
  studio.sky_nadir = {0.10f, 0.097f, 0.093f};
  // The integral of (horizon + (zenith - horizon) cos) cos over the upper half sphere.
  const glm::vec3 on_ground =
      kPi * studio.sky_horizon + (2.0f * kPi / 3.0f) * (studio.sky_zenith - studio.sky_horizon);
  studio.sky_on_ground_luminance =
      0.2126f * on_ground.x + 0.7152f * on_ground.y + 0.0722f * on_ground.z;
  studio.ground_height = floor;
  studio.ground_center = {center.x, floor, center.z};
  studio.ground_reach = 7.0f * radius;
  return studio;
}

Vec8 backdrop(Float8 film_x, Float8 film_y) {
  const Float8 x = film_x - 0.5f, y = film_y - 0.48f;
  const Float8 distance = x * x + y * y;  // 0 .. about 0.5 in the corners
  const Float8 light = 0.60f - 0.52f * distance / (1.0f + distance);
  return {0.985f * light, 0.995f * light, 1.02f * light};
}

}  // namespace backbend::render
