#include <cmath>
#include <limits>

#include "tests/validate/report_sample.h"
#include "validate/evidence/page_mesh.h"

namespace backbend::validate {
namespace {

constexpr std::uint32_t kRings = 96, kAround = 48;

/// A tube of 1.6 m whose upper half bends backward by `angle` radians, heated where it bends; one
/// band is left unmeasured.
std::vector<std::uint8_t> tube_pose(double angle) {
  std::vector<glm::vec3> position;
  std::vector<float> heat;
  double y = 0, z = 0, turn = 0;
  for (std::uint32_t ring = 0; ring < kRings; ++ring) {
    const double s = ring / (kRings - 1.0);
    const double bend = s < 0.5 ? 0 : angle * 3.14159265 / kRings * std::sin((s - 0.5) * 6.2831853);
    turn += bend;
    y += 1.6 / kRings * std::cos(turn);
    z -= 1.6 / kRings * std::sin(turn);
    const double radius =
        0.16 - 0.05 * std::cos(s * 9) - (ring == 0 || ring + 1 == kRings ? 0.1 : 0);
    for (std::uint32_t i = 0; i < kAround; ++i) {
      const double a = 6.2831853 * i / kAround;
      const double out = radius * std::cos(a);
      position.emplace_back(radius * 1.4 * std::sin(a), y + out * std::sin(turn),
                            z + out * std::cos(turn));
      heat.push_back(ring % 24 == 3 ? std::numeric_limits<float>::quiet_NaN()
                                    : static_cast<float>(bend * kRings));
    }
  }
  return encode_mesh_pose(position, heat, 0.0f, 5.0f);
}

std::vector<std::uint8_t> tube_triangles() {
  std::vector<glm::uvec3> triangles;
  for (std::uint32_t ring = 0; ring + 1 < kRings; ++ring)
    for (std::uint32_t i = 0; i < kAround; ++i) {
      const std::uint32_t a = ring * kAround + i, b = ring * kAround + (i + 1) % kAround;
      triangles.emplace_back(a, b, a + kAround);
      triangles.emplace_back(b, b + kAround, a + kAround);
    }
  return encode_mesh_triangles(triangles, kRings * kAround);
}

}  // namespace

std::vector<std::uint8_t> sample_mesh(const std::string& path) {
  if (path.ends_with(".triangles")) return tube_triangles();
  return tube_pose(path.find("isner") != std::string::npos ? 1.6 : 0.9);
}

}  // namespace backbend::validate
