#include "tests/skin/half_mesh.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <map>
#include <set>

namespace backbend::skin {

BodySolid ball(const glm::dvec3& center, double radius) {
  BodySolid part;
  part.shape = BodySolid::Shape::ellipsoid;
  part.center = center;
  part.radii = glm::dvec3(radius);
  part.blend = 0.0;
  return part;
}
BodyDescription body_of(std::vector<BodySolid> parts) {
  BodyDescription body;
  body.groups.push_back({"all", 0.0, std::move(parts)});
  return body;
}

HalfMesh mirrored(const HalfMesh& half) {
  HalfMesh out = half;
  std::vector<int> twin;
  for (int v = 0; v < static_cast<int>(half.position.size()); ++v) {
    twin.push_back(half.on_plane(v) ? v : static_cast<int>(out.position.size()));
    const glm::dvec3 p = half.position[z(v)];
    if (!half.on_plane(v)) out.position.emplace_back(-p.x, p.y, p.z);
  }
  for (const auto& t : half.triangle)
    out.triangle.push_back({twin[z(t[0])], twin[z(t[2])], twin[z(t[1])]});
  return out;
}

long euler(const HalfMesh& mesh) {
  std::map<std::pair<int, int>, int> sides;
  std::set<int> used;
  for (const auto& t : mesh.triangle)
    for (std::size_t k = 0; k < 3; ++k) {
      ++sides[{t[k], t[(k + 1) % 3]}];
      used.insert(t[k]);
    }
  for (const auto& [side, count] : sides)
    if (count != 1 || sides.count({side.second, side.first}) == 0) return -1000;
  return static_cast<long>(used.size()) - static_cast<long>(sides.size() / 2) +
         static_cast<long>(mesh.triangle.size());
}

double volume(const HalfMesh& mesh) {
  double sum = 0.0;
  for (const auto& t : mesh.triangle)
    sum += glm::dot(mesh.position[z(t[0])],
                    glm::cross(mesh.position[z(t[1])], mesh.position[z(t[2])])) /
           6.0;
  return sum;
}

double smallest_angle_deg(const HalfMesh& mesh) {
  double smallest = 180.0;
  for (const auto& t : mesh.triangle)
    for (std::size_t k = 0; k < 3; ++k) {
      const glm::dvec3& p = mesh.position[z(t[k])];
      const glm::dvec3 a = mesh.position[z(t[(k + 1) % 3])] - p,
                       b = mesh.position[z(t[(k + 2) % 3])] - p;
      smallest = std::min(smallest,
                          glm::degrees(std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b))));
    }
  return smallest;
}

BodyDescription two_balls() {
  BodyDescription body = body_of({ball(kLarge, 0.3), ball(kSmall, 0.1)});
  body.groups[0].parts[1].blend = 0.05;
  return body;
}

}  // namespace backbend::skin
