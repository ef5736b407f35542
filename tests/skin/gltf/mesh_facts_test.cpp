// Places, normals and weights of meshes, each against its definition tried the long way.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <random>

#include "skin/character/weld.h"
#include "skin/deform/linear_blend.h"
#include "skin/deform/smooth_normals.h"
#include "skin/gltf/vertex_weights.h"

namespace backbend::skin {
namespace {

TEST(Weld, NumbersPlacesByFirstAppearance) {
  std::mt19937 rng(2);
  for (const std::size_t count : {0u, 1u, 2u, 17u, 500u}) {
    std::vector<glm::vec3> points;
    for (std::size_t v = 0; v < count; ++v)
      points.emplace_back(static_cast<float>(rng() % 5) - 2.0f,
                          0.25f * static_cast<float>(rng() % 4), rng() % 3 == 0 ? -0.0f : 0.0f);
    const Places places = weld(points);
    ASSERT_EQ(places.place.size(), count);
    std::vector<glm::vec3> known;
    for (std::size_t v = 0; v < count; ++v) {
      const auto found = std::find(known.begin(), known.end(), points[v]);
      EXPECT_EQ(places.place[v], static_cast<std::uint32_t>(found - known.begin()));
      if (found == known.end()) known.push_back(points[v]);
    }
    EXPECT_EQ(places.count, known.size());
  }
  // Each coordinate tells points apart.
  const std::vector<glm::vec3> apart = {{1, 2, 3}, {1, 2, 4}, {1, 5, 3}, {6, 2, 3}, {1, 2, 3}};
  EXPECT_EQ(weld(apart).place, (std::vector<std::uint32_t>{0, 1, 2, 3, 0}));
}

/// A fan of uneven triangles around a tip, its seam split; a part behind other vertices.
Character fan(Part& part) {
  Character c;
  for (int v = 0; v < 3; ++v) {
    c.bind_position.emplace_back(9.0f, static_cast<float>(v), 9.0f);
    c.bind_normal.emplace_back(0.0f);
  }
  c.triangles.emplace_back(0, 1, 2);
  part.first_vertex = 3;
  part.first_triangle = 1;
  c.bind_position.emplace_back(0.1f, 0.8f, -0.2f);
  c.bind_position.emplace_back(0.1f, 0.8f, -0.2f);
  const float angle[] = {0.0f, 0.7f, 2.1f, 3.0f, 4.6f, 6.2831853f};
  for (const float a : angle)
    c.bind_position.emplace_back(std::cos(a) * (1.0f + 0.2f * a), 0.1f * a, std::sin(a));
  c.bind_position.back() = c.bind_position[5];  // the seam
  c.bind_normal.resize(c.bind_position.size(), glm::vec3(0.0f));
  for (std::uint32_t k = 0; k < 5; ++k) c.triangles.emplace_back(3 + k % 2, 6 + k, 5 + k);
  c.triangles.emplace_back(3, 3, 4);  // without area
  part.vertex_count = 8;
  part.triangle_count = 6;
  return c;
}

TEST(SmoothNormals, AreTheAreasMeanAroundEachPlace) {
  for (const bool mirrored : {false, true}) {
    Part part;
    Character c = fan(part);
    c.bind_normal[7] = {0.0f, 0.6f, 0.8f};  // came with one
    ASSERT_TRUE(fill_missing_normals(c, part, mirrored));
    for (std::uint32_t v = 0; v < 3; ++v) EXPECT_EQ(c.bind_normal[v], glm::vec3(0.0f));
    EXPECT_EQ(c.bind_normal[7], glm::vec3(0.0f, 0.6f, 0.8f));
    for (std::uint32_t v = 3; v < c.vertex_count(); ++v) {
      if (v == 7) continue;
      glm::dvec3 sum(0.0);
      for (std::size_t t = 1; t < c.triangles.size(); ++t)
        for (int k = 0; k < 3; ++k) {
          if (c.bind_position[c.triangles[t][k]] != c.bind_position[v]) continue;
          const glm::dvec3 p(c.bind_position[c.triangles[t].x]),
              q(c.bind_position[c.triangles[t].y]), r(c.bind_position[c.triangles[t].z]);
          sum += glm::cross(q - p, r - p);
        }
      const glm::vec3 expected(glm::normalize(mirrored ? -sum : sum));
      EXPECT_LT(glm::distance(c.bind_normal[v], expected), 1e-6f) << v;
    }
    EXPECT_FALSE(fill_missing_normals(c, part, mirrored));  // none is missing any more
  }
  // Two triangles back to back: nothing is left, and up it is.
  Character flat;
  flat.bind_position = {{0, 0, 0}, {1, 0, 0}, {0, 0, 1}};
  flat.bind_normal.resize(3, glm::vec3(0.0f));
  flat.triangles = {{0, 1, 2}, {0, 2, 1}};
  Part part;
  part.vertex_count = 3;
  part.triangle_count = 2;
  EXPECT_TRUE(fill_missing_normals(flat, part, false));
  for (const glm::vec3& n : flat.bind_normal) EXPECT_EQ(n, glm::vec3(0, 1, 0));
  part.vertex_count = 0;
  EXPECT_FALSE(fill_missing_normals(flat, part, false));
}

TEST(NormalMatrix, KeepsNormalsSquareToTheirSurfaceUnderAnyMatrix) {
  std::mt19937 rng(4);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const glm::dmat4 turned =
      glm::rotate(glm::dmat4(1.0), 0.9, glm::normalize(glm::dvec3(1, 2, -0.5)));
  std::vector<glm::dmat4> matrices = {glm::dmat4(1.0), turned, glm::scale(turned, glm::dvec3(3.0)),
                                      glm::scale(turned, glm::dvec3(1, 1, -1)),
                                      glm::scale(turned, glm::dvec3(-2.0))};
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b)
      for (const double by : {-0.3, 0.3, -1e-3, 1e-3}) {
        glm::dmat4 sheared = turned;
        sheared[a] += by * turned[b];
        matrices.push_back(sheared);
      }
  for (const glm::dmat4& m : matrices) {
    const glm::dmat3 normals(normal_matrix(m));
    for (int i = 0; i < 20; ++i) {
      const glm::dvec3 u(unit(rng), unit(rng), unit(rng)), v(unit(rng), unit(rng), unit(rng));
      const glm::dvec3 n = glm::normalize(glm::cross(u, v));
      const glm::dvec3 out = glm::normalize(normals * n);
      EXPECT_NEAR(glm::dot(out, glm::normalize(glm::dmat3(m) * u)), 0.0, 2e-6);
      EXPECT_NEAR(glm::dot(out, glm::normalize(glm::dmat3(m) * v)), 0.0, 2e-6);
      // The side that was outside stays so.
      EXPECT_GT(glm::dot(out, glm::dmat3(m) * n), 0.0);
    }
    // Of the size of the matrix: blends between two kinds weigh fairly.
    EXPECT_NEAR(std::cbrt(std::abs(glm::determinant(normals))),
                std::cbrt(std::abs(glm::determinant(glm::dmat3(m)))), 1e-5);
  }
}

TEST(JointMatrices, KnowWhetherNormalsGoAnotherWayThanPoints) {
  const glm::dmat4 turned = glm::translate(
      glm::rotate(glm::dmat4(1.0), 0.9, glm::normalize(glm::dvec3(1, 2, -0.5))), {3, 4, 5});
  const struct {
    glm::dvec3 scale;
    bool uneven;
  } cases[] = {{{1, 1, 1}, false},       {{2.5, 2.5, 2.5}, false}, {{1, 1 + 4e-6, 1}, false},
               {{1, 1 + 1e-4, 1}, true}, {{2, 1, 1}, true},        {{-1, 1.5, 1}, true},
               {{-1, 1, -1}, false}};  // half a turn
  for (const auto& c : cases) {
    const glm::dmat4 m = glm::scale(turned, c.scale);
    const std::vector<glm::dmat4> nodes = {glm::dmat4(1.0), m * glm::inverse(turned)};
    const JointMatrices out = joint_matrices({{0, glm::dmat4(1.0)}, {1, turned}}, nodes);
    EXPECT_EQ(out.uneven, c.uneven) << c.scale.x << " " << c.scale.y << " " << c.scale.z;
    ASSERT_EQ(out.joint.size(), 2u);
    for (int column = 0; column < 4; ++column)
      for (int row = 0; row < 3; ++row)
        EXPECT_NEAR(out.joint[1].point[column][row], m[column][row], 1e-5);
    const glm::mat3 normal = normal_matrix(m);
    for (int column = 0; column < 3; ++column)
      for (int row = 0; row < 3; ++row)
        EXPECT_NEAR(out.joint[1].normal[column][row], normal[column][row], 1e-5);
  }
}

TEST(CanonicalInfluences, AreMergedSortedCutAndOfSumOne) {
  WeightTally tally;
  const std::vector<WeightEntry> entries = {{5, 0.1f}, {3, 0.2f}, {5, 0.3f}, {9, -0.5f},
                                            {2, 0.2f}, {7, 0.0f}, {1, 0.1f}};
  const Influences out = canonical_influences(entries, 1e-5, 41, tally);
  const std::uint16_t joint[] = {5, 2, 3, 1};
  const double weight[] = {0.4, 0.2, 0.2, 0.1};
  for (std::size_t k = 0; k < 4; ++k) {
    EXPECT_EQ(out.joint[k], joint[k]);
    EXPECT_NEAR(out.weight[k], weight[k] / 0.9, 1e-7);
  }
  EXPECT_EQ(out.weight[4], 0.0f);
  EXPECT_EQ(tally.vertices, 1u);
  EXPECT_EQ(tally.negative, 1u);
  EXPECT_EQ(tally.duplicates, 1u);
  EXPECT_EQ(tally.renormalised, 1u);
  EXPECT_EQ(tally.worst_vertex, 41u);
  EXPECT_NEAR(tally.worst_sum, 0.9, 1e-7);
  EXPECT_EQ(tally.cut, 0u);
  // A sum nearer to 1, on the other side, is not the worst; one further off is.
  canonical_influences(std::vector<WeightEntry>{{1, 1.05f}}, 1e-5, 42, tally);
  EXPECT_EQ(tally.worst_vertex, 41u);
  canonical_influences(std::vector<WeightEntry>{{1, 1.2f}}, 1e-5, 43, tally);
  EXPECT_EQ(tally.worst_vertex, 43u);
  EXPECT_NEAR(tally.worst_sum, 1.2, 1e-6);
  EXPECT_EQ(tally.renormalised, 3u);
  // Within the slack it is honest, but made 1 all the same.
  const Influences slack =
      canonical_influences(std::vector<WeightEntry>{{1, 0.6f}, {2, 0.39f}}, 0.011, 44, tally);
  EXPECT_EQ(tally.renormalised, 3u);
  EXPECT_NEAR(slack.weight[0] + slack.weight[1], 1.0f, 1e-7f);
  // Ten joints: the eight largest stay, and how much went is told.
  std::vector<WeightEntry> many;
  for (std::uint32_t j = 0; j < 10; ++j)
    many.push_back({j, 0.055f + 0.01f * static_cast<float>(j)});
  const Influences eight = canonical_influences(many, 1e-5, 45, tally);
  EXPECT_EQ(tally.cut, 1u);
  EXPECT_NEAR(tally.worst_cut, 0.12, 1e-6);
  float sum = 0.0f;
  for (std::size_t k = 0; k < kMaxInfluences; ++k) {
    EXPECT_EQ(eight.joint[k], 9 - k);
    EXPECT_NEAR(eight.weight[k], (0.145 - 0.01 * static_cast<double>(k)) / 0.88, 1e-6);
    sum += eight.weight[k];
  }
  EXPECT_NEAR(sum, 1.0f, 1e-6f);
  canonical_influences(std::vector<WeightEntry>(8, {3, 0.125f}), 1e-5, 46, tally);
  EXPECT_EQ(tally.cut, 1u);
  for (const float w : canonical_influences({}, 1e-5, 47, tally).weight) EXPECT_EQ(w, 0.0f);
  EXPECT_EQ(tally.vertices, 7u);
  std::vector<std::string> codes;
  for (const Warning& warning : weight_warnings(tally)) codes.push_back(warning.code);
  EXPECT_EQ(codes, (std::vector<std::string>{"weights_renormalised", "weights_negative",
                                             "influences_cut", "joint_repeated"}));
  EXPECT_TRUE(weight_warnings({}).empty());
}

}  // namespace
}  // namespace backbend::skin
