#include "validate/evidence/page_mesh.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <glm/common.hpp>
#include <limits>
#include <string_view>

#include "render/image/heat_map.h"

// Pose file: "BBP1", vertex count, box minimum and size (6 floats), 256 colours (sRGB, 3 bytes
// each; colour 0 is "not measured"), positions (3 x u16 a vertex), heat (u8 a vertex). Triangle
// file: "BBT1", vertex count, triangle count, indices (u16 where they fit, else u32).
// Little-endian, each part padded to 4 bytes. Read by web/85_mesh.js.
namespace backbend::validate {
namespace {

using Bytes = std::vector<std::uint8_t>;

void put(Bytes& out, std::uint32_t value, int bytes) {
  for (int i = 0; i < bytes; ++i) out.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
}
void put(Bytes& out, float value) { put(out, std::bit_cast<std::uint32_t>(value), 4); }
void magic(Bytes& out, std::string_view word) {
  for (const char c : word) out.push_back(static_cast<std::uint8_t>(c));
}
void pad(Bytes& out) { out.resize((out.size() + 3) / 4 * 4); }

bool is_finite(const glm::vec3& p) {
  return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

/// `fraction` of `steps`, rounded, in 0..steps.
std::uint32_t step_of(float fraction, float steps) {
  return static_cast<std::uint32_t>(std::lround(std::clamp(fraction, 0.0f, 1.0f) * steps));
}

std::uint8_t srgb(float linear) {
  const float encoded =
      linear <= 0.0031308f ? 12.92f * linear : 1.055f * std::pow(linear, 1.0f / 2.4f) - 0.055f;
  return static_cast<std::uint8_t>(step_of(encoded, 255.0f));
}

void put_palette(Bytes& out) {
  for (int i = 0; i < 256; ++i) {
    const float t =
        i == 0 ? std::numeric_limits<float>::quiet_NaN() : static_cast<float>(i - 1) / 254.0f;
    const glm::vec3 color = render::heat_color(t);
    for (int k = 0; k < 3; ++k) out.push_back(srgb(color[k]));
  }
}

}  // namespace

Bytes encode_mesh_pose(std::span<const glm::vec3> position, std::span<const float> heat,
                       float heat_low, float heat_high) {
  glm::vec3 low(0.0f), high(0.0f);
  bool first = true;
  for (const glm::vec3& p : position) {
    if (!is_finite(p)) continue;
    low = first ? p : glm::min(low, p);
    high = first ? p : glm::max(high, p);
    first = false;
  }
  const glm::vec3 size = high - low;
  Bytes out;
  out.reserve(800 + position.size() * 7);
  magic(out, "BBP1");
  put(out, static_cast<std::uint32_t>(position.size()), 4);
  for (int k = 0; k < 3; ++k) put(out, low[k]);
  for (int k = 0; k < 3; ++k) put(out, size[k]);
  put_palette(out);
  for (const glm::vec3& p : position)
    for (int k = 0; k < 3; ++k)
      put(out, is_finite(p) && size[k] > 0 ? step_of((p[k] - low[k]) / size[k], 65535.0f) : 0u, 2);
  pad(out);
  for (std::size_t v = 0; v < position.size(); ++v) {
    const bool known = v < heat.size() && std::isfinite(heat[v]) && heat_high > heat_low;
    out.push_back(known ? static_cast<std::uint8_t>(
                              1 + step_of((heat[v] - heat_low) / (heat_high - heat_low), 254.0f))
                        : std::uint8_t{0});
  }
  pad(out);
  return out;
}

Bytes encode_mesh_triangles(std::span<const glm::uvec3> triangle, std::uint32_t vertex_count) {
  const int bytes = vertex_count <= 65536 ? 2 : 4;
  Bytes out;
  out.reserve(12 + triangle.size() * 3 * static_cast<std::size_t>(bytes));
  magic(out, "BBT1");
  put(out, vertex_count, 4);
  put(out, static_cast<std::uint32_t>(triangle.size()), 4);
  for (const glm::uvec3& t : triangle)
    for (int k = 0; k < 3; ++k) put(out, t[k], bytes);
  pad(out);
  return out;
}

}  // namespace backbend::validate
