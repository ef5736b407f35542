// Even triangles of the wanted size, on the surface.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>

#include "skin/body/body_edge_sizes.h"
#include "skin/body/body_grid.h"
#include "skin/body/body_remesh.h"
#include "tests/skin/half_mesh.h"

namespace backbend::skin {
namespace {

std::vector<double> edge_lengths(const HalfMesh& mesh) {
  std::vector<double> out;
  for (const auto& t : mesh.triangle)
    for (std::size_t k = 0; k < 3; ++k)
      if (t[k] < t[(k + 1) % 3] || (mesh.on_plane(t[k]) && mesh.on_plane(t[(k + 1) % 3])))
        out.push_back(glm::distance(mesh.position[z(t[k])], mesh.position[z(t[(k + 1) % 3])]));
  return out;
}

TEST(BodyRemesh, MakesEvenTrianglesOfTheWantedSizeOnTheSurface) {
  for (const double x : {0.0, 0.8}) {
    const glm::dvec3 center(x, 0.2, -0.1);
    BodySolid part = ball(center, 1.0);
    part.radii = {0.3, 0.36, 0.33};
    const BodyDescription body = body_of({part});
    const BodyShape shape(body);
    HalfMesh mesh = grid_surface(shape, center, 0.03);
    const double vertices = x == 0.0 ? 300.0 : 600.0;
    const EdgeSizes sizes(mesh, shape, 0.03, 1.0, 1.0, vertices);  // one size for all
    const double wanted = sizes.at(mesh.position[0]);
    int polled = 0;
    remesh(mesh, shape, sizes, 7, [&] { ++polled; });
    EXPECT_GE(polled, 8);
    EXPECT_EQ(euler(mirrored(mesh)), x == 0.0 ? 2 : 4);
    EXPECT_NEAR(static_cast<double>(mesh.position.size()), vertices, 0.1 * vertices);
    EXPECT_GT(smallest_angle_deg(mesh), x == 0.0 ? 25.0 : 30.0);
    double sum = 0.0;
    const std::vector<double> lengths = edge_lengths(mesh);
    for (const double length : lengths) {
      EXPECT_GT(length, (x == 0.0 ? 0.3 : 0.55) * wanted);
      EXPECT_LT(length, 1.45 * wanted);
      sum += length;
    }
    EXPECT_NEAR(sum / static_cast<double>(lengths.size()), 0.93 * wanted, 0.05 * wanted);
    const Connectivity net(mesh);
    std::size_t regular = 0, border = 0, inside = 0;
    for (int v = 0; v < static_cast<int>(mesh.position.size()); ++v) {
      EXPECT_LT(std::abs(shape.value(mesh.position[z(v)])), 2e-7);
      if (mesh.on_plane(v)) {
        ++border;
        EXPECT_GE(net.valence(v), 3);
        EXPECT_LE(net.valence(v), 5);
        continue;
      }
      EXPECT_GT(mesh.position[z(v)].x, 0.1 * wanted);
      ++inside;
      regular += net.valence(v) == 6;
      EXPECT_GE(net.valence(v), 4);
      EXPECT_LE(net.valence(v), 8);
    }
    EXPECT_GT(static_cast<double>(regular), 0.7 * static_cast<double>(inside));
    // The border is an ellipse of about 2.17 m, cut into pieces of that size.
    EXPECT_NEAR(static_cast<double>(border), x == 0.0 ? 2.17 / (0.93 * wanted) : 0.0,
                x == 0.0 ? 7.0 : 0.0);
  }
}

TEST(BodyRemesh, MakesSmallerTrianglesWhereTheSizesAskForThem) {
  const BodyDescription body = two_balls();
  const BodyShape shape(body);
  HalfMesh mesh = grid_surface(shape, kLarge, 0.02);
  const EdgeSizes sizes(mesh, shape, 0.02, 0.35, 1.5, 900.0);
  remesh(mesh, shape, sizes, 7, [] {});
  EXPECT_EQ(euler(mesh), 2);
  EXPECT_NEAR(static_cast<double>(mesh.position.size()), 900.0, 90.0);
  EXPECT_GT(smallest_angle_deg(mesh), 25.0);
  for (const auto& t : mesh.triangle)
    for (std::size_t k = 0; k < 3; ++k) {
      const glm::dvec3 &a = mesh.position[z(t[k])], &b = mesh.position[z(t[(k + 1) % 3])];
      const double ratio = glm::distance(a, b) / (0.5 * (sizes.at(a) + sizes.at(b)));
      EXPECT_GT(ratio, 0.5);
      EXPECT_LT(ratio, 1.5);
    }
}

}  // namespace
}  // namespace backbend::skin
