// How long edges are to be, against closed forms.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <random>

#include "skin/body/body_edge_sizes.h"
#include "skin/body/body_grid.h"
#include "tests/skin/half_mesh.h"

namespace backbend::skin {
namespace {

std::vector<double> areas(const HalfMesh& mesh) {
  std::vector<double> area(mesh.position.size(), 0.0);
  for (const auto& t : mesh.triangle) {
    const glm::dvec3 &a = mesh.position[z(t[0])], &b = mesh.position[z(t[1])],
                     &c = mesh.position[z(t[2])];
    for (const int v : t) area[z(v)] += glm::length(glm::cross(b - a, c - a)) / 6.0;
  }
  return area;
}

TEST(BodyEdgeSizes, OfABallAreThoseOfAsManyEvenTriangles) {
  const BodyDescription body = body_of({ball(kLarge, 0.3)});
  const BodyShape shape(body);
  HalfMesh mesh = grid_surface(shape, kLarge, 0.02);
  // On the ball itself, where every edge bends by its length over the radius.
  for (glm::dvec3& p : mesh.position) p = shape.project(p, 0.1);
  for (const double vertices : {300.0, 1500.0}) {
    EdgeSizes sizes(mesh, shape, 0.02, 0.35, 1.5, vertices);
    // N vertices of six even triangles each: area = N sqrt(3)/2 L^2; 0.93 as the code says why.
    const double edge = std::sqrt(4.0 * kPi * 0.09 / (0.5 * std::sqrt(3.0) * vertices)) / 0.93;
    // Vertices in a knot of edges too short to tell count as flat: measured 8 % beside such.
    double mean = 0.0;
    for (const glm::dvec3& p : mesh.position) {
      ASSERT_NEAR(sizes.at(p), edge, 0.1 * edge);
      mean += sizes.at(p) / static_cast<double>(mesh.position.size());
    }
    EXPECT_NEAR(mean, edge, 0.005 * edge);
    const double first = sizes.at(mesh.position[7]);
    sizes.scale(0.5);
    sizes.scale(3.0);
    EXPECT_DOUBLE_EQ(sizes.at(mesh.position[7]), 1.5 * first);
  }
}

TEST(BodyEdgeSizes, GoByTheRootOfTheCurvatureWithinTheirBounds) {
  const BodyDescription body = two_balls();
  const BodyShape shape(body);
  const HalfMesh mesh = grid_surface(shape, kLarge, 0.015);
  const std::vector<double> area = areas(mesh);
  const glm::dvec3 behind = kLarge - glm::dvec3(0.3, 0, 0), tip = kSmall + glm::dvec3(0.1, 0, 0);
  const struct {
    double finest, coarsest, ratio;
  } cases[] = {{0.35, 1.5, std::sqrt(0.1 / 0.3)},
               {0.8, 1.5, 0.8},
               {0.35, 0.9, std::sqrt(0.1 / 0.3) / 0.9},
               {1.0, 1.0, 1.0}};
  for (const auto& c : cases) {
    const EdgeSizes sizes(mesh, shape, 0.015, c.finest, c.coarsest, 800.0);
    EXPECT_NEAR(sizes.at(tip) / sizes.at(behind), c.ratio, 0.05 * c.ratio);
    // Whatever they are, they are for as many vertices.
    double vertices = 0.0;
    for (std::size_t v = 0; v < mesh.position.size(); ++v) {
      const double size = sizes.at(mesh.position[v]);
      vertices += area[v] / (0.5 * std::sqrt(3.0) * size * size);
    }
    EXPECT_NEAR(vertices, 800.0 * 0.93 * 0.93, 1e-6);
    // They change slowly: a cell's length is nothing beside the melted seam.
    for (const auto& t : mesh.triangle)
      ASSERT_NEAR(std::log(sizes.at(mesh.position[z(t[0])]) / sizes.at(mesh.position[z(t[1])])),
                  0.0, 0.35);
  }
}

TEST(BodyEdgeSizes, AtAnyPlaceAreThoseOfTheNearestVertex) {
  const BodyDescription body = two_balls();
  const BodyShape shape(body);
  const HalfMesh mesh = grid_surface(shape, kLarge, 0.02);
  const EdgeSizes sizes(mesh, shape, 0.02, 0.35, 1.5, 500.0);
  std::mt19937 rng(3);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  for (int i = 0; i < 300; ++i) {
    const glm::dvec3 p = mesh.position[rng() % mesh.position.size()] +
                         0.02 * glm::dvec3(unit(rng), unit(rng), unit(rng));
    std::size_t nearest = 0;
    for (std::size_t v = 1; v < mesh.position.size(); ++v)
      if (glm::distance(mesh.position[v], p) < glm::distance(mesh.position[nearest], p))
        nearest = v;
    ASSERT_EQ(sizes.at(p), sizes.at(mesh.position[nearest]));
  }
  // Off the surface by some cells there is still a size, one of those near.
  EXPECT_NEAR(sizes.at(kSmall), sizes.at(kSmall + glm::dvec3(0.1, 0, 0)), 0.2 * sizes.at(kSmall));
  EXPECT_GT(sizes.at({9, 9, 9}), 0.0);
}

}  // namespace
}  // namespace backbend::skin
