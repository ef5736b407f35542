// Splits, collapses and flips, against what keeps a mesh a surface.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <random>
#include <set>

#include "skin/body/body_connectivity.h"
#include "skin/body/body_grid.h"
#include "skin/body/body_subdivide.h"
#include "tests/skin/half_mesh.h"

namespace backbend::skin {
namespace {

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

}  // namespace
}  // namespace backbend::skin
