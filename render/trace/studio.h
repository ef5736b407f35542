#pragma once
#include <array>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>

#include "render/image/lanes.h"
#include "render/trace/environment_map.h"
#include "render/trace/projection.h"

namespace backbend::render {

/// A rectangle that shines from the side its normal points to.
struct AreaLight {
  glm::vec3 center, half_u, half_v;  // world space; half_u and half_v are orthogonal
  glm::vec3 normal;                  // unit
  float area;
  float extent;  // from the centre to a corner
  float power;   // area times luminance of the radiance
  glm::vec3 radiance;
};

/// Lights around a character: a large key, a weak fill and a rim behind, turned with the camera
/// about the vertical so that every view is lit alike, and a sky that brightens upwards. An
/// environment picture takes the place of them all.
struct Studio {
  std::array<AreaLight, 3> light;
  glm::vec3 sky_zenith, sky_horizon, sky_nadir;  // radiance
  std::optional<EnvironmentMap> environment;
  bool has_ground = true;
  float ground_height = 0.0f;  // world y
  glm::vec3 ground_albedo{0.35f};
  glm::vec3 ground_center{0.0f};  // shadows are looked for around here
  float ground_reach = 1.0f;      // and fade out between half this distance and this distance

  float sky_on_ground_luminance = 0.0f;  // irradiance of the unoccluded sky on the ground
};

/// `radius` > 0 is the size of the character around `center`; lights scale with it. They stand as
/// the camera wants them, turned by `turn_deg` about the vertical.
Studio make_studio(const Projection& camera, const glm::vec3& center, float radius, float floor,
                   double turn_deg = 0.0);

/// The colour behind everything at film positions in 0..1: lighter in the middle, without horizon.
Vec8 backdrop(Float8 film_x, Float8 film_y);

}  // namespace backbend::render
