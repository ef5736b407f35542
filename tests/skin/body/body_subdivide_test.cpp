// A mesh cut in four, and mended where it is thin.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <set>

#include "skin/body/body_edge_sizes.h"
#include "skin/body/body_grid.h"
#include "skin/body/body_remesh.h"
#include "skin/body/body_subdivide.h"
#include "tests/skin/half_mesh.h"

namespace backbend::skin {
namespace {

TEST(BodySubdivide, CutsEveryTriangleInFourOnTheSurface) {
  for (const double x : {0.0, 0.9}) {
    const glm::dvec3 center(x, -0.1, 0.2);
    const BodyDescription body = body_of({ball(center, 0.4)});
    const BodyShape shape(body);
    HalfMesh mesh = grid_surface(shape, center, 0.1);
    for (glm::dvec3& p : mesh.position) p = shape.project(p, 1.0);
    const HalfMesh coarse = mesh;
    std::vector<std::array<int, 2>> edge_of = {{7, 7}};
    subdivide(mesh, shape, edge_of);
    EXPECT_EQ(mesh.triangle.size(), 4 * coarse.triangle.size());
    EXPECT_EQ(mesh.position.size(), coarse.position.size() + edge_of.size());
    EXPECT_EQ(euler(mirrored(mesh)), x == 0.0 ? 2 : 4);
    std::set<std::array<int, 2>> edges;
    for (const auto& t : coarse.triangle)
      for (std::size_t k = 0; k < 3; ++k)
        edges.insert({std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3])});
    EXPECT_EQ(edge_of, std::vector(edges.begin(), edges.end()));
    for (std::size_t v = 0; v < mesh.position.size(); ++v) {
      const glm::dvec3& p = mesh.position[v];
      if (v < coarse.position.size()) {
        ASSERT_EQ(p, coarse.position[v]);
        continue;
      }
      const auto [a, b] = edge_of[v - coarse.position.size()];
      const glm::dvec3 middle = 0.5 * (coarse.position[z(a)] + coarse.position[z(b)]);
      // On a ball: outwards from the middle of the edge.
      const glm::dvec3 on = center + 0.4 * glm::normalize(middle - center);
      if (coarse.on_plane(a) && coarse.on_plane(b)) {
        ASSERT_EQ(p.x, 0.0);
      } else {
        ASSERT_GT(p.x, 0.0);
      }
      ASSERT_LT(glm::distance(p, on), 1e-6);
    }
    // The four of each triangle stand where it stood, and face as it did.
    for (std::size_t t = 0; t < coarse.triangle.size(); ++t) {
      std::map<int, int> corners;
      glm::dvec3 sum(0.0);
      for (std::size_t k = 4 * t; k < 4 * t + 4; ++k) {
        const auto& f = mesh.triangle[k];
        const glm::dvec3 &p = mesh.position[z(f[0])], &q = mesh.position[z(f[1])],
                         &r = mesh.position[z(f[2])];
        const glm::dvec3 cross = glm::cross(q - p, r - p);
        EXPECT_GT(glm::dot(cross, p - center), 0.0);
        sum += cross;
        for (const int v : f) ++corners[v];
      }
      EXPECT_EQ(corners.size(), 6u);
      for (const int v : coarse.triangle[t]) EXPECT_EQ(corners[v], 1);
    }
  }
}

HalfMesh even_mesh(const BodyShape& shape, const glm::dvec3& seed, double vertices) {
  HalfMesh mesh = grid_surface(shape, seed, 0.08);
  remesh(mesh, shape, EdgeSizes(mesh, shape, 0.08, 0.5, 1.5, vertices), 5, [] {});
  return mesh;
}

TEST(BodySubdivide, MendsWhatIsThinOrTurnedOverAndNothingElse) {
  const glm::dvec3 center(0.9, -0.1, 0.2);
  const BodyDescription body = body_of({ball(center, 0.4)});
  const BodyShape shape(body);
  HalfMesh mesh = even_mesh(shape, center, 300.0);
  const HalfMesh even = mesh;
  mend(mesh, shape);
  EXPECT_EQ(mesh.position, even.position);  // all is well: nothing moves
  std::vector<int> ring;
  const Connectivity net(mesh);
  // One vertex slides to its neighbour, so that what lies between them is thin; another one beyond
  // its own, so that a triangle turns over.
  for (const auto& [vertex, slide] : {std::pair(40, 0.93), std::pair(120, 1.3)}) {
    HalfMesh bent = even;
    net.neighbours(vertex, ring);
    glm::dvec3& p = bent.position[z(vertex)];
    p = shape.project(glm::mix(p, even.position[z(ring[0])], slide), 1.0);
    ASSERT_LT(smallest_angle_deg(bent), 13.0);
    mend(bent, shape);
    EXPECT_GT(smallest_angle_deg(bent), 20.0);
    EXPECT_LT(std::abs(shape.value(p)), 1e-6);
    double worst = 0.0;
    std::size_t moved = 0;
    for (std::size_t v = 0; v < bent.position.size(); ++v) {
      const double by = glm::distance(bent.position[v], even.position[v]);
      worst = std::max(worst, by);
      moved += by > 0.0;
      EXPECT_LT(std::abs(shape.value(bent.position[v])), 1e-6);
    }
    EXPECT_LT(moved, 12u);  // it and the corners of what was thin
    EXPECT_LT(worst, 0.06);
    for (const auto& t : bent.triangle) {
      const glm::dvec3 &a = bent.position[z(t[0])], &b = bent.position[z(t[1])],
                       &c = bent.position[z(t[2])];
      EXPECT_GT(glm::dot(glm::cross(b - a, c - a), a - center), 0.0);
    }
  }
}

TEST(BodySubdivide, MendsBesideTheMirrorPlaneWithoutMovingWhatLiesInIt) {
  const glm::dvec3 center(0.0, -0.1, 0.2);
  const BodyDescription body = body_of({ball(center, 0.4)});
  const BodyShape shape(body);
  const HalfMesh mesh = even_mesh(shape, center, 150.0);
  std::vector<int> ring;
  int tried = 0;
  for (int v = 0; v < static_cast<int>(mesh.position.size()); ++v) {
    if (mesh.on_plane(v)) continue;
    HalfMesh bent = mesh;
    Connectivity(bent).neighbours(v, ring);
    const auto beside =
        std::find_if(ring.begin(), ring.end(), [&](int n) { return mesh.on_plane(n); });
    if (beside == ring.end() || ++tried > 6) continue;
    bent.position[z(v)] =
        shape.project(glm::mix(mesh.position[z(v)], mesh.position[z(*beside)], 0.9), 1.0);
    mend(bent, shape);
    EXPECT_GT(smallest_angle_deg(bent), 10.0) << v;
    for (std::size_t k = 0; k < bent.position.size(); ++k) {
      if (mesh.position[k].x == 0.0) {
        EXPECT_EQ(bent.position[k], mesh.position[k]);
      } else {
        EXPECT_GT(bent.position[k].x, 0.0);
      }
    }
  }
  EXPECT_GT(tried, 6);
}

}  // namespace
}  // namespace backbend::skin
