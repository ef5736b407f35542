// The way from solids to an even mesh, step by step: the grid's surface against a plain count,
// edge sizes against closed forms, edits and subdivision against what keeps a mesh a surface.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <random>
#include <set>
#include <tuple>

#include "skin/body_connectivity.h"
#include "skin/body_edge_sizes.h"
#include "skin/body_grid.h"
#include "skin/body_remesh.h"
#include "skin/body_subdivide.h"

namespace backbend::skin {
namespace {

constexpr double kPi = 3.14159265358979323846;

std::size_t z(int i) { return static_cast<std::size_t>(i); }

BodySolid ball(const glm::dvec3& center, double radius) {
  BodySolid part;
  part.shape = BodySolid::Shape::ellipsoid;
  part.center = center;
  part.radii = glm::dvec3(radius);
  part.blend = 0.0;
  part.joints = {0};
  return part;
}
BodyDescription body_of(std::vector<BodySolid> parts) {
  BodyDescription body;
  body.joints.push_back({"root", -1, 0, parts[0].center});
  body.groups.push_back({"all", 0.0, std::move(parts)});
  return body;
}

/// Both sides of x = 0 as one mesh: the half's vertices, then the images of those off the plane.
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

/// V - E + F; -1000 where an edge does not run exactly once each way.
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

std::vector<double> areas(const HalfMesh& mesh) {
  std::vector<double> area(mesh.position.size(), 0.0);
  for (const auto& t : mesh.triangle) {
    const glm::dvec3 &a = mesh.position[z(t[0])], &b = mesh.position[z(t[1])],
                     &c = mesh.position[z(t[2])];
    for (const int v : t) area[z(v)] += glm::length(glm::cross(b - a, c - a)) / 6.0;
  }
  return area;
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

std::vector<double> edge_lengths(const HalfMesh& mesh) {
  std::vector<double> out;
  for (const auto& t : mesh.triangle)
    for (std::size_t k = 0; k < 3; ++k)
      if (t[k] < t[(k + 1) % 3] || (mesh.on_plane(t[k]) && mesh.on_plane(t[(k + 1) % 3])))
        out.push_back(glm::distance(mesh.position[z(t[k])], mesh.position[z(t[(k + 1) % 3])]));
  return out;
}

// The grid ---------------------------------------------------------------------------------------

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

// Sizes ------------------------------------------------------------------------------------------

/// A large ball that melts with a small one, wholly beside the mirror plane.
const glm::dvec3 kLarge(1.0, 0.1, -0.2), kSmall(1.33, 0.1, -0.2);
BodyDescription two_balls() {
  BodyDescription body = body_of({ball(kLarge, 0.3), ball(kSmall, 0.1)});
  body.groups[0].parts[1].blend = 0.05;
  return body;
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

// Edits ------------------------------------------------------------------------------------------

/// The half of a double pyramid about x = 0 whose rim, of `rim` points, lies in y = 0: open in the
/// plane; valences known by hand. And a closed one beside the plane.
HalfMesh pyramid(int rim, double middle) {
  HalfMesh out;
  for (int k = 0; k < rim; ++k) {
    const double a = 2.0 * kPi * k / rim;
    out.position.emplace_back(middle + 0.5 * std::cos(a), 0.0, 0.5 * std::sin(a));
  }
  out.position.emplace_back(middle, 0.7, 0.0);
  out.position.emplace_back(middle, -0.6, 0.0);
  for (int k = 0; k < rim; ++k) {
    const int next = (k + 1) % rim;
    out.triangle.push_back({next, k, rim});
    out.triangle.push_back({k, next, rim + 1});
  }
  return out;
}

/// What Connectivity says against the triangles themselves.
void expect_consistent(const Connectivity& net, const HalfMesh& mesh) {
  std::vector<std::set<int>> faces(mesh.position.size()), around(mesh.position.size());
  for (std::size_t f = 0; f < mesh.triangle.size(); ++f) {
    if (mesh.triangle[f][0] < 0) continue;
    for (const int a : mesh.triangle[f]) {
      faces[z(a)].insert(static_cast<int>(f));
      for (const int b : mesh.triangle[f])
        if (a != b) around[z(a)].insert(b);
    }
  }
  std::vector<int> ring;
  for (int v = 0; v < static_cast<int>(mesh.position.size()); ++v) {
    ASSERT_EQ(net.faces(v).size(), faces[z(v)].size()) << v;
    ASSERT_TRUE(std::set<int>(net.faces(v).begin(), net.faces(v).end()) == faces[z(v)]) << v;
    net.neighbours(v, ring);
    ASSERT_EQ(ring, std::vector<int>(around[z(v)].begin(), around[z(v)].end())) << v;
    if (ring.empty()) continue;
    ASSERT_EQ(net.valence(v), static_cast<int>(ring.size())) << v;
  }
}

TEST(BodyConnectivity, KeepsAMirroredSurfaceThroughAnyEditsThatItAllows) {
  BodySolid middle = ball({0.0, 0.1, 0.2}, 0.3);
  for (const bool halved : {false, true}) {
    const glm::dvec3 center = halved ? glm::dvec3(0.0, 0.1, 0.2) : glm::dvec3(1.0, 0.1, 0.2);
    middle.center = center;
    const BodyDescription body = body_of({middle});
    HalfMesh mesh = grid_surface(BodyShape(body), center, 0.12);
    Connectivity net(mesh);
    std::mt19937 rng(11);
    std::vector<int> ring;
    int splits = 0, collapses = 0, flips = 0, refused = 0;
    for (int i = 0; i < 1500; ++i) {
      const int a = static_cast<int>(rng() % mesh.position.size());
      net.neighbours(a, ring);
      if (ring.empty()) continue;
      const int b = ring[rng() % ring.size()];
      const auto kind = rng() % 8;
      int c = -1, d = -1;
      if (kind == 0) {
        const glm::dvec3 p = 0.5 * (mesh.position[z(a)] + mesh.position[z(b)]);
        const int fresh = net.split(a, b, p);
        ASSERT_EQ(fresh, static_cast<int>(mesh.position.size()) - 1);
        EXPECT_EQ(mesh.position.back(), p);
        ++splits;
      } else if (kind < 4) {
        if (net.may_collapse(a, b)) {
          const std::size_t least = !mesh.on_plane(a) && mesh.on_plane(b) ? 4 : 5;
          net.collapse(a, b);
          net.neighbours(b, ring);
          ASSERT_GE(ring.size(), least);
          EXPECT_TRUE(net.faces(a).empty());
          ++collapses;
        } else {
          ++refused;
        }
      } else if (net.may_flip(a, b, &c, &d)) {
        std::set<std::array<int, 3>> turned;
        for (auto t : mesh.triangle) {
          std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
          turned.insert(t);
        }
        const auto has = [&](std::array<int, 3> t) {
          std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
          return turned.count(t) == 1;
        };
        ASSERT_TRUE(has({a, b, c}) && has({b, a, d}));
        net.flip(a, b, c, d);
        ++flips;
      } else {
        ++refused;
      }
      if (i % 100 != 0 && i != 1499) continue;
      expect_consistent(net, mesh);
      HalfMesh whole = mesh;
      std::erase_if(whole.triangle, [](const auto& t) { return t[0] < 0; });
      whole = mirrored(whole);
      // Two balls, where there is no plane between them.
      ASSERT_EQ(euler(whole), halved ? 2 : 4) << i;
      for (int v = 0; v < static_cast<int>(whole.position.size()); ++v) {
        std::size_t valence = 0;
        for (const auto& t : whole.triangle) valence += t[0] == v || t[1] == v || t[2] == v;
        ASSERT_TRUE(valence == 0 || valence >= 4) << v;  // as many as on a split edge
      }
    }
    EXPECT_GT(splits, 100);
    EXPECT_GT(collapses, 100);
    EXPECT_GT(flips, 100);
    EXPECT_GT(refused, 50);
    const std::size_t faces = static_cast<std::size_t>(std::count_if(
        mesh.triangle.begin(), mesh.triangle.end(), [](const auto& t) { return t[0] >= 0; }));
    std::vector<glm::dvec3> kept;
    for (int v = 0; v < static_cast<int>(mesh.position.size()); ++v)
      if (!net.faces(v).empty()) kept.push_back(mesh.position[z(v)]);
    net.compact();
    EXPECT_EQ(mesh.position, kept);
    EXPECT_EQ(mesh.triangle.size(), faces);
    expect_consistent(net, mesh);
  }
}

TEST(BodyConnectivity, LeavesNoVertexFewerThanFourNeighbours) {
  // A double pyramid over n points: the rim has four neighbours each, the two tips n.
  for (const int rim : {4, 5, 6, 8}) {
    HalfMesh mesh = pyramid(rim, 2.0);
    ASSERT_EQ(euler(mesh), 2);
    ASSERT_GT(volume(mesh), 0.0);
    const Connectivity net(mesh);
    EXPECT_EQ(net.valence(rim), rim);
    EXPECT_EQ(net.valence(0), 4);
    int c = -1, d = -1;
    // Two of the rim would leave one of four where they meet; from rim to tip the two beside it,
    // which have four, lose one.
    EXPECT_FALSE(net.may_collapse(0, 1));
    EXPECT_FALSE(net.may_collapse(0, rim));
    EXPECT_FALSE(net.may_collapse(rim, 0));
    EXPECT_FALSE(net.may_flip(0, 1, &c, &d));  // the rim's points have four
    EXPECT_FALSE(net.may_flip(0, rim, &c, &d));
  }
  // Not so few that the whole becomes flat: all of a tetrahedron's edges stay.
  HalfMesh four;
  four.position = {{1, 0, 0}, {2, 0, 0}, {1, 1, 0}, {1, 0, 1}};
  four.triangle = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  ASSERT_EQ(euler(four), 2);
  const Connectivity net(four);
  for (int a = 0; a < 4; ++a)
    for (int b = 0; b < 4; ++b) {
      int c = -1, d = -1;
      if (a == b) continue;
      EXPECT_FALSE(net.may_collapse(a, b));
      EXPECT_FALSE(net.may_flip(a, b, &c, &d));
    }
}

TEST(BodyConnectivity, TakesEveryEditOfARoundMeshOfSixNeighbours) {
  // An icosahedron's points have five neighbours, those in the middle of its edges six.
  const double g = 0.5 * (1.0 + std::sqrt(5.0));
  HalfMesh mesh;
  for (const double s : {-1.0, 1.0})
    for (const double t : {-g, g}) {
      mesh.position.emplace_back(5.0, s, t);
      mesh.position.emplace_back(5.0 + s, t, 0.0);
      mesh.position.emplace_back(5.0 + t, 0.0, s);
    }
  const glm::dvec3 middle(5.0, 0.0, 0.0);
  for (int a = 0; a < 12; ++a)
    for (int b = a + 1; b < 12; ++b)
      for (int c = b + 1; c < 12; ++c) {
        const glm::dvec3 &p = mesh.position[z(a)], &q = mesh.position[z(b)],
                         &r = mesh.position[z(c)];
        if (std::max({glm::distance(p, q), glm::distance(q, r), glm::distance(r, p)}) > 2.1)
          continue;
        const bool outward = glm::dot(glm::cross(q - p, r - p), p - middle) > 0.0;
        mesh.triangle.push_back({a, outward ? b : c, outward ? c : b});
      }
  ASSERT_EQ(mesh.triangle.size(), 20u);
  {
    Connectivity net(mesh);
    std::vector<int> ring;
    int a = 0, c = -1, d = -1;
    net.neighbours(a, ring);
    const int b = ring[0];
    EXPECT_TRUE(net.may_collapse(a, b));
    ASSERT_TRUE(net.may_flip(a, b, &c, &d));
    HalfMesh flipped = mesh;
    Connectivity four(flipped);
    four.flip(a, b, c, d);  // a and b have four now, c and d six
    net.neighbours(a, ring);
    for (const int n : ring) {
      if (n == b) continue;
      int e = -1, f = -1;
      // Into one of five all goes well: five are left there. Around the two of six, those of five
      // beside them would go on with four, but one of four may lose none.
      EXPECT_TRUE(four.may_collapse(a, n)) << n;
      EXPECT_FALSE(four.may_flip(a, n, &e, &f));
    }
    EXPECT_TRUE(four.may_flip(c, d, &a, &c));
  }
  const BodyDescription body = body_of({ball(middle, 2.0)});
  std::vector<std::array<int, 2>> edge_of;
  subdivide(mesh, BodyShape(body), edge_of);
  ASSERT_EQ(euler(mesh), 2);
  Connectivity net(mesh);
  std::vector<int> ring;
  for (int a = 0; a < static_cast<int>(mesh.position.size()); ++a) {
    net.neighbours(a, ring);
    EXPECT_EQ(ring.size(), a < 12 ? 5u : 6u);
    for (const int b : ring) {
      int c = -1, d = -1;
      EXPECT_TRUE(net.may_collapse(a, b));
      EXPECT_TRUE(net.may_flip(a, b, &c, &d));
    }
  }
}

// Subdivision ------------------------------------------------------------------------------------

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

TEST(BodySubdivide, MendsWhatIsThinOrTurnedOverAndNothingElse) {
  const glm::dvec3 center(0.9, -0.1, 0.2);
  const BodyDescription body = body_of({ball(center, 0.4)});
  const BodyShape shape(body);
  HalfMesh mesh = grid_surface(shape, center, 0.08);
  remesh(mesh, shape, EdgeSizes(mesh, shape, 0.08, 0.5, 1.5, 300.0), 5, [] {});
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
  HalfMesh mesh = grid_surface(shape, center, 0.08);
  remesh(mesh, shape, EdgeSizes(mesh, shape, 0.08, 0.5, 1.5, 150.0), 5, [] {});
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

// Remeshing --------------------------------------------------------------------------------------

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
