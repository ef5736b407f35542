// The surface of solids on a grid, against a plain count of every crossing.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <tuple>

#include "skin/body/body_grid.h"
#include "tests/skin/half_mesh.h"

namespace backbend::skin {
namespace {

/// What marching tetrahedra must give, by asking every cube of a box: the vertices, one on each
/// edge of the tetrahedra that crosses the surface, and how many triangles.
std::pair<std::vector<glm::dvec3>, std::size_t> marched(const BodyShape& shape, double cell,
                                                        const glm::ivec3& low,
                                                        const glm::ivec3& high) {
  const auto value = [&](const glm::ivec3& n) { return shape.value(glm::dvec3(n) * cell); };
  std::vector<glm::dvec3> vertices;
  std::size_t triangles = 0;
  // Around the diagonal of each cube: the three axes in any order.
  constexpr int kOrder[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
  for (int i = low.x; i < high.x; ++i)
    for (int j = low.y; j < high.y; ++j)
      for (int k = low.z; k < high.z; ++k) {
        const glm::ivec3 n(i, j, k);
        for (int s = 1; s < 8; ++s) {
          const glm::ivec3 step(s & 1, s >> 1 & 1, s >> 2 & 1);
          const double a = value(n), b = value(n + step);
          if ((a < 0.0) == (b < 0.0)) continue;
          vertices.push_back((glm::dvec3(n) + a / (a - b) * glm::dvec3(step)) * cell);
        }
        for (const auto& order : kOrder) {
          glm::ivec3 corner = n;
          int inside = value(corner) < 0.0;
          for (const int axis : order) {
            ++corner[axis];
            inside += value(corner) < 0.0;
          }
          triangles += inside == 2 ? 2u : inside == 1 || inside == 3 ? 1u : 0u;
        }
      }
  return {vertices, triangles};
}

bool before(const glm::dvec3& a, const glm::dvec3& b) {
  return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
}

TEST(BodyGrid, FindsEveryCrossingOfTheTetrahedraOnceAndNoOther) {
  // Off the grid, about the origin and far below it, so that counting to either side is tried.
  const struct {
    glm::dvec3 center, radii;
    double cell;
  } cases[] = {{{0.53, 0.021, -0.013}, {0.31, 0.17, 0.23}, 0.0413},
               {{0.61, -7.3, 5.2}, {0.21, 0.33, 0.27}, 0.0517}};
  for (const auto& c : cases) {
    BodySolid part = ball(c.center, 1.0);
    part.radii = c.radii;
    const BodyDescription body = body_of({part});
    const BodyShape shape(body);
    HalfMesh mesh = grid_surface(shape, c.center, c.cell);
    EXPECT_EQ(euler(mesh), 2);
    const glm::ivec3 low(glm::floor((c.center - c.radii) / c.cell) - 2.0),
        high(glm::ceil((c.center + c.radii) / c.cell) + 2.0);
    auto [vertices, triangles] = marched(shape, c.cell, low, high);
    EXPECT_EQ(mesh.triangle.size(), triangles);
    ASSERT_EQ(mesh.position.size(), vertices.size());
    // Anticlockwise from outside: the volume is above 0, and that of the ellipsoid to second order.
    const double whole = 4.0 / 3.0 * kPi * c.radii.x * c.radii.y * c.radii.z;
    for (glm::dvec3& p : mesh.position) p -= c.center;
    EXPECT_NEAR(volume(mesh), whole, 0.03 * whole);
    for (const auto& t : mesh.triangle) {
      const glm::dvec3 &p = mesh.position[z(t[0])], &q = mesh.position[z(t[1])],
                       &r = mesh.position[z(t[2])];
      ASSERT_GE(glm::dot(glm::cross(q - p, r - p), (p + q + r) / (c.radii * c.radii)), -1e-12);
    }
    for (glm::dvec3& p : mesh.position) p += c.center;
    // Vertices keep a fiftieth of the edge away from the nodes.
    std::sort(mesh.position.begin(), mesh.position.end(), before);
    std::vector<bool> taken(vertices.size(), false);
    for (const glm::dvec3& p : mesh.position) {
      std::size_t best = 0;
      double nearest = INFINITY;
      for (std::size_t i = 0; i < vertices.size(); ++i)
        if (const double d = glm::distance(p, vertices[i]); !taken[i] && d < nearest)
          nearest = d, best = i;
      taken[best] = true;
      ASSERT_LT(nearest, 0.02 * std::sqrt(3.0) * c.cell);
      const glm::dvec3 on = p / c.cell - glm::round(p / c.cell);
      ASSERT_GT(glm::length(on), 0.0199);
    }
  }
}

TEST(BodyGrid, IsOpenInTheMirrorPlaneAndNowhereElse) {
  BodySolid part = ball({0.0, 0.3, 0.1}, 1.0);
  part.radii = {0.4, 0.3, 0.25};
  const BodyDescription body = body_of({part});
  const BodyShape shape(body);
  const HalfMesh half = grid_surface(shape, {0.0, 0.3, 0.1}, 0.037);
  for (const glm::dvec3& p : half.position) EXPECT_GE(p.x, 0.0);
  EXPECT_EQ(euler(mirrored(half)), 2);
  EXPECT_NEAR(volume(mirrored(half)), 4.0 / 3.0 * kPi * 0.4 * 0.3 * 0.25, 0.003);
}

TEST(BodyGrid, FollowsOnlyTheShellAroundItsSeed) {
  const BodyDescription body = body_of({ball({1, 0, 0}, 0.2), ball({2, 0.4, 0.3}, 0.3)});
  const BodyShape shape(body);
  for (const auto& [seed, radius] :
       {std::pair(glm::dvec3(1, 0, 0.1), 0.2), std::pair(glm::dvec3(2.1, 0.3, 0.3), 0.3)}) {
    HalfMesh mesh = grid_surface(shape, seed, 0.03);
    for (glm::dvec3& p : mesh.position) p -= seed;
    EXPECT_EQ(euler(mesh), 2);
    EXPECT_NEAR(volume(mesh), 4.0 / 3.0 * kPi * radius * radius * radius, 0.0025);
  }
  EXPECT_THROW(grid_surface(shape, {1, 0.25, 0}, 0.03), CharacterError);
  EXPECT_THROW(grid_surface(shape, {1, 0, -0.25}, 0.03), CharacterError);
  // A seed left of the plane is that of its mirror image.
  EXPECT_EQ(grid_surface(shape, {-1, 0, 0.1}, 0.03).position,
            grid_surface(shape, {1, 0, 0.1}, 0.03).position);
}

}  // namespace
}  // namespace backbend::skin
