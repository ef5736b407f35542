#include "render/trace/surface.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace backbend::render {
namespace {

// Bilinear, repeating in both directions, v downwards from the top row as glTF has it.
glm::vec4 sample_texture(const Texture& texture, glm::vec2 uv) {
  const auto wrap = [](float at, int size) {
    const float texels = (at - std::floor(at)) * static_cast<float>(size) - 0.5f;
    const float low = std::floor(texels);
    const int first = (static_cast<int>(low) + size) % size;
    return std::tuple{first, (first + 1) % size, texels - low};
  };
  const auto [x0, x1, fx] = wrap(uv.x, texture.width);
  const auto [y0, y1, fy] = wrap(uv.y, texture.height);
  const auto at = [&](int x, int y) {
    return texture.texel[static_cast<std::size_t>(y) * texture.width + x];
  };
  const glm::vec4 top = at(x0, y0) * (1.0f - fx) + at(x1, y0) * fx;
  const glm::vec4 bottom = at(x0, y1) * (1.0f - fx) + at(x1, y1) * fx;
  return top * (1.0f - fy) + bottom * fy;
}

struct MaterialLookup {
  const Material* material;
  glm::vec2 uv;
  bool has_uv;
};

MaterialLookup look_up(const MeshTopology& mesh, const Surface8& at, unsigned lane) {
  static const Material plain;
  MaterialLookup found{&plain, {0.0f, 0.0f}, false};
  if (!mesh.triangle_material.empty())
    found.material = &mesh.materials[mesh.triangle_material[at.triangle[lane]]];
  if (!mesh.uv.empty()) {
    found.uv = interpolate(std::span<const glm::vec2>(mesh.uv), at, lane);
    found.has_uv = std::isfinite(found.uv.x) && std::isfinite(found.uv.y);
  }
  return found;
}

glm::vec3 base_color(const MeshTopology& mesh, const MaterialLookup& at) {
  glm::vec3 color = at.material->base_color;
  if (at.has_uv && at.material->base_color_texture >= 0)
    color *= glm::vec3(sample_texture(mesh.textures[at.material->base_color_texture], at.uv));
  return glm::clamp(color, glm::vec3(0.0f), glm::vec3(1.0f));
}

// Turns the shading normal by a tangent-space picture; the tangent is the direction of growing u.
glm::vec3 mapped_normal(const SceneView& scene, const Surface8& surface, unsigned lane,
                        const MaterialLookup& at) {
  const MeshTopology& mesh = *scene.mesh;
  const glm::uvec3 v = mesh.triangle[surface.triangle[lane]];
  const glm::vec3 shading = surface.shading.lane(lane);
  const glm::vec3 e1 = scene.pose.position[v.y] - scene.pose.position[v.x];
  const glm::vec3 e2 = scene.pose.position[v.z] - scene.pose.position[v.x];
  const glm::vec2 d1 = mesh.uv[v.y] - mesh.uv[v.x], d2 = mesh.uv[v.z] - mesh.uv[v.x];
  const float determinant = d1.x * d2.y - d2.x * d1.y;
  if (!(std::abs(determinant) > 1e-20f)) return shading;
  glm::vec3 tangent = (e1 * d2.y - e2 * d1.y) / determinant;
  const glm::vec3 down = (e2 * d1.x - e1 * d2.x) / determinant;  // along growing v
  tangent -= shading * glm::dot(shading, tangent);
  const float length = glm::length(tangent);
  if (!(length > 1e-20f)) return shading;
  tangent /= length;
  const glm::vec3 side = glm::cross(shading, tangent);
  const glm::vec3 up = glm::dot(side, down) > 0.0f ? -side : side;  // glTF's +Y of the picture
  const glm::vec3 texel =
      glm::vec3(sample_texture(mesh.textures[at.material->normal_texture], at.uv)) * 2.0f - 1.0f;
  const glm::vec3 n = tangent * texel.x + up * texel.y + shading * std::max(texel.z, 0.05f);
  return glm::normalize(n);
}

Vec8 gather3(std::span<const glm::vec3> from, Int8 index) {
  const float* base = &from[0].x;
  const Int8 at = index * 3;
  return {gather(base, at), gather(base + 1, at), gather(base + 2, at)};
}

}  // namespace

Surface8 surface_at(const SceneView& scene, Int8 triangle, const Vec8& origin,
                    const Vec8& direction) {
  const Float8 zero = splat(0.0f), one = splat(1.0f);
  Surface8 s;
  s.triangle = triangle;
  const auto* corner = reinterpret_cast<const std::int32_t*>(scene.mesh->triangle.data());
  Vec8 p[3], n[3];
  for (int i = 0; i < 3; ++i) {
    s.vertex[i] = gather(corner + i, triangle * 3);
    p[i] = gather3(scene.pose.position, s.vertex[i]);
    n[i] = gather3(scene.pose.normal, s.vertex[i]);
  }
  const Vec8 e1 = p[1] - p[0], e2 = p[2] - p[0];
  const Vec8 across = cross(direction, e2), from = origin - p[0];
  const Float8 determinant = dot(e1, across);
  const Int8 flat = determinant == zero;  // seen exactly edge-on: any point of it will do
  const Float8 scale = one / (flat ? one : determinant);
  Float8 u = flat ? splat(1.0f / 3.0f) : dot(from, across) * scale;
  Float8 w = flat ? splat(1.0f / 3.0f) : dot(direction, cross(from, e1)) * scale;
  // The device called it a hit; rounding may put it a hair outside.
  u = clamp(u, 0.0f, 1.0f);
  w = min(max(w, zero), one - u);
  s.barycentric = {one - u - w, u, w};
  s.position = p[0] + e1 * u + e2 * w;
  const Vec8 normal = cross(e1, e2);
  const Float8 area = length(normal);
  const Int8 degenerate = area == zero;
  s.geometric =
      select(degenerate, -normalize(direction), normal * (one / (degenerate ? one : area)));
  const Float8 side = dot(s.geometric, direction) > zero ? -one : one;
  s.geometric = s.geometric * side;
  for (Vec8& normal_of_vertex : n) normal_of_vertex = normal_of_vertex * side;
  const Vec8 smooth = n[0] * s.barycentric.x + n[1] * u + n[2] * w;
  const Float8 smooth_length = length(smooth);
  // A normal that disagrees with its triangle by more than a right angle would turn light to dark.
  const Int8 usable = (smooth_length > 1e-6f) & (dot(smooth, s.geometric) > zero);
  s.shading = select(usable, smooth * (one / (usable ? smooth_length : one)), s.geometric);
  // Lift onto the tangent planes of the vertices, wherever the point lies below them.
  const auto lift = [&](int i, Float8 weight) {
    return n[i] * (weight * max(zero, dot(p[i] - s.position, n[i])));
  };
  const Vec8 lifted = lift(0, s.barycentric.x) + lift(1, u) + lift(2, w);
  s.launch = s.position + lifted + s.geometric * splat(1e-4f * scene.rest_radius);
  return s;
}

std::uint8_t region_at(const MeshTopology& mesh, const Surface8& at, unsigned lane) {
  std::uint8_t region[3], best = 0;
  float most = -1.0f;
  const glm::vec3 weight = at.barycentric.lane(lane);
  for (int i = 0; i < 3; ++i) region[i] = mesh.vertex_region[at.vertex[i][lane]];
  for (int i = 0; i < 3; ++i) {
    float sum = 0.0f;
    for (int j = 0; j < 3; ++j) sum += region[j] == region[i] ? weight[j] : 0.0f;
    if (sum > most) most = sum, best = region[i];
  }
  return best;
}

glm::vec3 base_color_at(const SceneView& scene, const Surface8& at, unsigned lane) {
  return base_color(*scene.mesh, look_up(*scene.mesh, at, lane));
}

Bsdf8 material_at(const SceneView& scene, Surface8& at, unsigned mask) {
  const MeshTopology& mesh = *scene.mesh;
  Bsdf8 bsdf{.alpha = splat(1.0f), .has_coat = true};
  for (; mask != 0; mask &= mask - 1) {
    const auto lane = static_cast<unsigned>(std::countr_zero(mask));
    const MaterialLookup look = look_up(mesh, at, lane);
    const glm::vec3 color = base_color(mesh, look);
    float roughness = look.material->roughness, metallic = look.material->metallic;
    if (look.has_uv && look.material->roughness_metallic_texture >= 0) {
      const glm::vec4 t =
          sample_texture(mesh.textures[look.material->roughness_metallic_texture], look.uv);
      roughness *= t.y;
      metallic *= t.z;
    }
    if (look.has_uv && look.material->normal_texture >= 0)
      at.shading.set_lane(lane, mapped_normal(scene, at, lane, look));
    roughness = std::clamp(roughness, 0.045f, 1.0f);  // narrower lobes than this are only noise
    metallic = std::clamp(metallic, 0.0f, 1.0f);
    bsdf.diffuse.set_lane(lane, color * (1.0f - metallic));
    bsdf.specular.set_lane(lane, glm::vec3(0.04f) * (1.0f - metallic) + color * metallic);
    bsdf.alpha[lane] = roughness * roughness;
  }
  return bsdf;
}

}  // namespace backbend::render
