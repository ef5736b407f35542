#include "tests/render/mesh_fixture.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <numbers>

namespace backbend::render {
namespace {

constexpr float kPi = std::numbers::pi_v<float>;

TestMesh finish(std::vector<glm::vec3> position, std::vector<glm::vec3> normal,
                std::vector<glm::uvec3> triangle, std::vector<std::uint8_t> region,
                std::vector<std::string> names) {
  TestMesh mesh;
  mesh.topology = std::make_shared<MeshTopology>();
  mesh.topology->triangle = std::move(triangle);
  mesh.topology->vertex_region = std::move(region);
  mesh.topology->region_name = std::move(names);
  mesh.topology->object_name = "figure";
  mesh.topology->rest_position = position;
  mesh.topology->materials.emplace_back();
  mesh.topology->triangle_material.assign(mesh.topology->triangle.size(), 0);
  mesh.position = std::move(position);
  mesh.normal = std::move(normal);
  return mesh;
}

// A grid of `u` x `v` quads, wound so that dP/du x dP/dv is the outside. A degenerate edge at the
// poles of a sphere is left out.
struct Grid {
  std::vector<glm::vec3> position, normal;
  std::vector<glm::uvec3> triangle;

  void add(int u_count, int v_count,
           const std::function<void(float, float, glm::vec3&, glm::vec3&)>& surface) {
    const auto first = static_cast<unsigned>(position.size());
    for (int v = 0; v <= v_count; ++v) {
      for (int u = 0; u <= u_count; ++u) {
        glm::vec3 p, n;
        surface(static_cast<float>(u) / u_count, static_cast<float>(v) / v_count, p, n);
        position.push_back(p);
        normal.push_back(n);
      }
    }
    const auto row = static_cast<unsigned>(u_count + 1);
    for (unsigned v = 0; v < static_cast<unsigned>(v_count); ++v) {
      for (unsigned u = 0; u < static_cast<unsigned>(u_count); ++u) {
        const unsigned a = first + v * row + u, b = a + 1, c = a + row, d = c + 1;
        for (const glm::uvec3 t : {glm::uvec3(a, b, d), glm::uvec3(a, d, c)})
          if (glm::length(glm::cross(position[t.y] - position[t.x],
                                     position[t.z] - position[t.x])) > 1e-12f)
            triangle.push_back(t);
      }
    }
  }

  // A sphere pulled apart along `axis` by `length` on each side: a capsule.
  void add_capsule(const glm::vec3& center, float radius, const glm::vec3& half_axis, int rings) {
    add(2 * rings, rings, [&](float u, float v, glm::vec3& p, glm::vec3& n) {
      const float longitude = 2.0f * kPi * u, latitude = kPi * v;
      n = {std::sin(latitude) * std::sin(longitude), -std::cos(latitude),
           std::sin(latitude) * std::cos(longitude)};
      const float side = glm::dot(n, half_axis) >= 0.0f ? 1.0f : -1.0f;
      p = center + n * radius + half_axis * side;
    });
  }
};

}  // namespace

TestMesh sphere(const glm::vec3& center, float radius, int rings) {
  Grid grid;
  grid.add_capsule(center, radius, glm::vec3(0.0f), rings);
  const std::size_t vertices = grid.position.size();
  return finish(grid.position, grid.normal, grid.triangle, std::vector<std::uint8_t>(vertices, 0),
                {"torso"});
}

TestMesh square(float edge) {
  const float h = 0.5f * edge;
  return finish({{-h, -h, 0}, {h, -h, 0}, {h, h, 0}, {-h, h, 0}},
                std::vector<glm::vec3>(4, {0, 0, 1}), {{0, 1, 2}, {0, 2, 3}}, {0, 0, 0, 0},
                {"torso"});
}

TestMesh torus(float ring_radius, float tube_radius, int segments) {
  Grid grid;
  grid.add(2 * segments, segments, [&](float u, float v, glm::vec3& p, glm::vec3& n) {
    const float around = 2.0f * kPi * u, tube = 2.0f * kPi * v;
    const glm::vec3 out(std::sin(around), 0.0f, std::cos(around));
    n = out * std::cos(tube) + glm::vec3(0, 1, 0) * std::sin(tube);
    p = out * ring_radius + n * tube_radius + glm::vec3(0, tube_radius, 0);
  });
  std::vector<std::uint8_t> region;
  for (const glm::vec3& p : grid.position) region.push_back(p.x > 0.0f ? 1 : 0);
  return finish(grid.position, grid.normal, grid.triangle, region, {"torso", "arm_L"});
}

TestMesh blob_figure() {
  Grid grid;
  grid.add_capsule({0, 1.62f, 0}, 0.13f, {0, 0.02f, 0}, 48);  // head
  grid.add_capsule({0, 1.15f, 0}, 0.17f, {0, 0.19f, 0}, 48);  // torso
  const std::size_t torso_end = grid.position.size();
  grid.add_capsule({0.36f, 1.30f, 0}, 0.055f, {0.22f, 0.03f, 0}, 32);  // arms
  const std::size_t left_end = grid.position.size();
  grid.add_capsule({-0.36f, 1.30f, 0}, 0.055f, {-0.22f, 0.03f, 0}, 32);
  const std::size_t right_end = grid.position.size();
  grid.add_capsule({0.09f, 0.45f, 0}, 0.085f, {0.02f, -0.36f, 0}, 32);  // legs
  grid.add_capsule({-0.09f, 0.45f, 0}, 0.085f, {-0.02f, -0.36f, 0}, 32);
  std::vector<std::uint8_t> region;
  for (std::size_t i = 0; i < grid.position.size(); ++i)
    region.push_back(i < torso_end ? 0 : i < left_end ? 1 : i < right_end ? 2 : 3);
  return finish(grid.position, grid.normal, grid.triangle, region,
                {"torso", "arm_L", "arm_R", "legs"});
}

TestMesh bent(const TestMesh& mesh, float radians) {
  TestMesh out = mesh;
  for (std::size_t i = 0; i < mesh.position.size(); ++i) {
    const glm::vec3 p = mesh.position[i], n = mesh.normal[i];
    const float angle = radians * std::clamp((p.y - 0.8f) / 0.6f, 0.0f, 1.0f);
    const float c = std::cos(angle), s = std::sin(angle);
    const float y = p.y - 0.8f;
    out.position[i] = {p.x, 0.8f + y * c - p.z * s, y * s + p.z * c};
    out.normal[i] = {n.x, n.y * c - n.z * s, n.y * s + n.z * c};
  }
  return out;
}

}  // namespace backbend::render
