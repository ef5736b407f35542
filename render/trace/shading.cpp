#include "render/trace/shading.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "render/image/heat_map.h"

namespace backbend::render {
namespace {

glm::vec3 in_camera(const Projection& p, const glm::vec3& n) {
  return {glm::dot(n, glm::vec3(p.right)), glm::dot(n, glm::vec3(p.up)),
          -glm::dot(n, glm::vec3(p.forward))};
}

}  // namespace

glm::vec3 fixed_light_shade(const Projection& projection, const glm::vec3& normal) {
  const glm::vec3 n = in_camera(projection, normal);
  const float key = std::max(0.0f, glm::dot(n, glm::vec3(-0.4800f, 0.6400f, 0.6000f)));
  const float view = std::max(0.0f, n.z);
  return glm::vec3(0.04f + 0.42f * key + 0.14f * view);
}

glm::vec3 matcap_shade(const Projection& projection, const glm::vec3& normal,
                       const glm::vec3& out) {
  const glm::vec3 n = in_camera(projection, normal);
  const glm::vec3 view = in_camera(projection, out);
  const glm::vec3 mirrored = 2.0f * glm::dot(n, view) * n - view;
  const float sky = 0.5f + 0.5f * n.y;
  const float soft = std::max(0.0f, glm::dot(mirrored, glm::vec3(-0.41f, 0.57f, 0.71f)));
  const float edge = 1.0f - std::max(0.0f, glm::dot(n, view));
  const glm::vec3 body = glm::vec3(0.10f, 0.075f, 0.065f) * (0.35f + 0.65f * sky);
  const float soft4 = soft * soft * soft * soft;
  return body + glm::vec3(0.42f, 0.38f, 0.35f) * soft4 * 0.55f +
         glm::vec3(0.9f, 0.88f, 0.85f) * (soft4 * soft4 * soft4 * soft4 * 0.5f) +
         glm::vec3(0.20f, 0.25f, 0.32f) * (edge * edge * edge * (0.4f + 0.6f * sky));
}

glm::vec3 paper_shade(const Projection& projection, const glm::vec3& normal) {
  const glm::vec3 n = in_camera(projection, normal);
  const float light = std::max(0.0f, glm::dot(n, glm::vec3(-0.30f, 0.40f, 0.866f)));
  return glm::vec3(0.90f) * (0.55f + 0.45f * light);
}

glm::vec3 heat_shade(const Projection& projection, const glm::vec3& normal, float value, float low,
                     float high) {
  const glm::vec3 n = in_camera(projection, normal);
  const float form = 0.62f + 0.38f * std::max(0.0f, glm::dot(n, glm::vec3(-0.30f, 0.40f, 0.866f)));
  const float range = high - low;
  return heat_color(range > 0.0f ? (value - low) / range : value - value) * form;
}

glm::vec3 albedo_at(const SceneView& scene, Mode mode, const Surface8& at, unsigned lane) {
  return mode == Mode::beauty ? base_color_at(scene, at, lane) : kClayAlbedo;
}

}  // namespace backbend::render
