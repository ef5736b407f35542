#include "validate/metrics/surface/self_intersection.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <numeric>
#include <random>

#include "validate/metrics/math/rotation.h"

namespace backbend::validate {
namespace {

using Triangle = std::array<glm::vec3, 3>;

bool met(const Triangle& a, const Triangle& b) {
  return triangles_meet({a[0], a[1], a[2]}, {b[0], b[1], b[2]});
}

/// Separating axes: closed convex figures are apart where, and only where, their shadows on one of
/// these axes are. Exact for small whole coordinates.
bool met_by_axes(const Triangle& a, const Triangle& b) {
  std::vector<glm::dvec3> axis, edge_a, edge_b;
  for (int i = 0; i < 3; ++i) {
    edge_a.push_back(glm::dvec3(a[(i + 1) % 3]) - glm::dvec3(a[i]));
    edge_b.push_back(glm::dvec3(b[(i + 1) % 3]) - glm::dvec3(b[i]));
  }
  const glm::dvec3 normal_a = glm::cross(edge_a[0], edge_a[1]);
  const glm::dvec3 normal_b = glm::cross(edge_b[0], edge_b[1]);
  axis = {normal_a, normal_b};
  for (const glm::dvec3& e : edge_a) {
    for (const glm::dvec3& f : edge_b) axis.push_back(glm::cross(e, f));
    axis.push_back(glm::cross(normal_a, e));
  }
  for (const glm::dvec3& f : edge_b) axis.push_back(glm::cross(normal_b, f));
  for (const glm::dvec3& n : axis) {
    const auto shadow = [&](const Triangle& t) {
      std::array<double, 3> s{};
      for (int i = 0; i < 3; ++i) s[i] = glm::dot(n, glm::dvec3(t[i]));
      return std::minmax({s[0], s[1], s[2]});
    };
    const auto [a_low, a_high] = shadow(a);
    const auto [b_low, b_high] = shadow(b);
    if (a_high < b_low || b_high < a_low) return false;
  }
  return true;
}

TEST(TrianglesMeet, AgreesWithSeparatingAxesOnALatticeWhereEverythingTouches) {
  std::mt19937 rng(1);
  const auto corner = [&] {
    const auto whole = [&] { return static_cast<float>(static_cast<int>(rng() % 5) - 2); };
    const float x = whole(), y = whole();
    return glm::vec3(x, y, whole());
  };
  int looked_at = 0, meeting = 0, flat = 0;
  for (int i = 0; i < 200'000; ++i) {
    const Triangle a{corner(), corner(), corner()}, b{corner(), corner(), corner()};
    const glm::vec3 n = glm::cross(a[1] - a[0], a[2] - a[0]);
    const glm::vec3 m = glm::cross(b[1] - b[0], b[2] - b[0]);
    if (n == glm::vec3(0.0f) || m == glm::vec3(0.0f)) continue;  // no triangles
    const bool expected = met_by_axes(a, b);
    ASSERT_EQ(met(a, b), expected) << "pair " << i;
    ASSERT_EQ(met(b, a), expected) << "pair " << i;
    ASSERT_EQ(met({a[2], a[1], a[0]}, b), expected) << "pair " << i;
    ++looked_at;
    meeting += expected;
    flat += glm::cross(n, m) == glm::vec3(0.0f) && glm::dot(n, b[0] - a[0]) == 0.0f;
  }
  EXPECT_GT(looked_at, 150'000);
  EXPECT_GT(meeting, looked_at / 4);
  EXPECT_LT(meeting, looked_at);
  EXPECT_GT(flat, 100) << "triangles of one plane";
}

TEST(TrianglesMeet, ToTheLastBitOfAFloat) {
  const Triangle table{{{-1, -1, 1}, {1, -1, 1}, {0, 1, 1}}};
  const float above = std::nextafter(1.0f, 2.0f), below = std::nextafter(1.0f, 0.0f);
  const auto leg = [](float top) { return Triangle{{{0, 0, top}, {0.1f, 0, 0}, {-0.1f, 0, 0}}}; };
  EXPECT_TRUE(met(table, leg(above)));
  EXPECT_TRUE(met(table, leg(1.0f)));
  EXPECT_FALSE(met(table, leg(below)));
}

TEST(TrianglesMeet, FarAwayAlongAnyAxisAsAtHome) {
  // A needle through a table, and one that stops short of it, thin across the axis that they are
  // moved along; every number is exact, near and far.
  const Triangle table{{{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}}};
  const Triangle through{{{0, 0, -0.25f}, {0.125f, 0, 1}, {-0.125f, 0, 1}}};
  const Triangle above{{{0, 0, 0.25f}, {0.125f, 0, 1}, {-0.125f, 0, 1}}};
  const auto moved = [](Triangle triangle, int axis, float way) {
    for (glm::vec3& corner : triangle)
      for (int c = 0; c < 3; ++c) corner[c] = c == axis ? corner[c] + way : corner[c] / 65536.0f;
    return triangle;
  };
  for (int axis = 0; axis < 3; ++axis)
    for (const float way : {0.0f, 64.0f, -64.0f, 4096.0f, -4096.0f}) {
      EXPECT_TRUE(met(moved(table, axis, way), moved(through, axis, way))) << axis << " " << way;
      EXPECT_FALSE(met(moved(table, axis, way), moved(above, axis, way))) << axis << " " << way;
    }
}

/// A closed tube along y of `rings` rings of `around` corners, its ends fanned.
struct ClosedTube {
  std::vector<glm::vec3> position;
  std::vector<glm::uvec3> triangle;
  std::vector<std::uint32_t> place;

  ClosedTube(int rings, int around) {
    const auto at = [&](int ring, int k) {
      return static_cast<std::uint32_t>(ring * around + k % around);
    };
    for (int r = 0; r < rings; ++r)
      for (int k = 0; k < around; ++k) {
        const double angle = 2.0 * kPi * k / around;
        position.emplace_back(0.1 * std::cos(angle), static_cast<double>(r) / (rings - 1),
                              0.1 * std::sin(angle));
      }
    for (int r = 0; r + 1 < rings; ++r)
      for (int k = 0; k < around; ++k) {
        triangle.emplace_back(at(r, k), at(r + 1, k), at(r, k + 1));
        triangle.emplace_back(at(r, k + 1), at(r + 1, k), at(r + 1, k + 1));
      }
    for (int k = 1; k + 1 < around; ++k) {
      triangle.emplace_back(at(0, 0), at(0, k), at(0, k + 1));
      triangle.emplace_back(at(rings - 1, 0), at(rings - 1, k + 1), at(rings - 1, k));
    }
    place.resize(position.size());
    std::iota(place.begin(), place.end(), 0u);
  }

  /// Bent back over a circle by `turn` radians; beyond a full turn the ends run into each other.
  std::vector<glm::vec3> bent(double turn) const {
    std::vector<glm::vec3> out;
    for (const glm::vec3& p : position) {
      const double angle = turn * p.y, radius = 1.0 / turn;
      out.emplace_back(p.x, (radius + p.z) * std::sin(angle),
                       radius - (radius + p.z) * std::cos(angle));
    }
    return out;
  }
};

std::vector<SelfIntersection::Pair> by_trying_all(const ClosedTube& tube,
                                                  const std::vector<glm::vec3>& position) {
  std::vector<SelfIntersection::Pair> out;
  const auto corners = [&](std::size_t t) {
    const glm::uvec3& c = tube.triangle[t];
    return Triangle{position[c.x], position[c.y], position[c.z]};
  };
  for (std::size_t a = 0; a < tube.triangle.size(); ++a)
    for (std::size_t b = a + 1; b < tube.triangle.size(); ++b) {
      bool neighbours = false;
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) neighbours |= tube.triangle[a][i] == tube.triangle[b][j];
      if (!neighbours && met(corners(a), corners(b)))
        out.push_back({static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(b)});
    }
  return out;
}

void expect_what_trying_all_pairs_finds(const ClosedTube& tube) {
  const SelfIntersection mesh(tube.position, tube.triangle, tube.place);
  for (const double turn : {0.5, 3.0, 6.0, 6.5, 7.0, 9.0, 14.0}) {
    const std::vector<glm::vec3> posed = tube.bent(turn);
    EXPECT_EQ(mesh.pairs(posed), by_trying_all(tube, posed)) << turn;
  }
  // A crumpled ball of the same triangles, where a fifth of all pairs meets.
  std::mt19937 rng(2);
  std::vector<glm::vec3> crumpled;
  const auto number = [&] { return static_cast<float>(rng() >> 8) * 0x1p-24f; };
  for (std::size_t v = 0; v < tube.position.size(); ++v) {
    const float x = number(), y = number();
    crumpled.emplace_back(x, y, number());
  }
  const auto found = mesh.pairs(crumpled);
  EXPECT_GT(found.size(), 1000u);
  EXPECT_EQ(found, by_trying_all(tube, crumpled));
}

TEST(SelfIntersection, FindsWhatTryingAllPairsFinds) {
  expect_what_trying_all_pairs_finds(ClosedTube(24, 8));
}

TEST(SelfIntersection, WhereManyTrianglesShareAPlace) {
  expect_what_trying_all_pairs_finds(ClosedTube(5, 40));  // fans of 38 close its ends
}

TEST(SelfIntersection, OfATubeBeginsWhereItsEndsRunIntoEachOther) {
  const ClosedTube tube(120, 16);
  const SelfIntersection mesh(tube.position, tube.triangle, tube.place);
  // Below a full turn the ends are apart, and the inner side (radius 1 / turn > 0.1) keeps its
  // length.
  for (const double turn : {0.01, 1.0, 3.0, 6.0, 6.28})
    EXPECT_EQ(mesh.measure(tube.bent(turn)).pairs, 0u) << turn;
  const auto over = mesh.measure(tube.bent(6.6));
  EXPECT_GT(over.pairs, 0u);
  EXPECT_GT(over.area, 0.0);
  EXPECT_LT(over.area, 0.3);
  ASSERT_GE(over.vertex, 0);
  const float along = tube.position[static_cast<std::size_t>(over.vertex)].y;
  EXPECT_TRUE(along < 0.1f || along > 0.9f) << along;
  // The inner side folds once the circle is smaller than the tube is thick.
  EXPECT_GT(mesh.measure(tube.bent(14.0)).pairs, over.pairs);
}

TEST(SelfIntersection, CountsOnlyWhatIsNewAgainstRest) {
  ClosedTube tube(40, 12);
  tube.position = tube.bent(6.6);  // as modelled: it runs through itself
  const SelfIntersection mesh(tube.position, tube.triangle, tube.place);
  EXPECT_GT(mesh.pairs(tube.position).size(), 0u);
  EXPECT_EQ(mesh.measure(tube.position).pairs, 0u);
  EXPECT_EQ(mesh.measure(tube.position).vertex, -1);
  const auto further = ClosedTube(40, 12).bent(6.65);
  EXPECT_GT(mesh.new_pairs(further).size(), 0u);
  EXPECT_LT(mesh.new_pairs(further).size(), mesh.pairs(further).size());
}

TEST(SelfIntersection, OfShellsThatAreInEachOtherAtRestIsNeverNew) {
  const ClosedTube tube(40, 12);
  const auto with_second = [&](float across, float along) {
    std::vector<glm::vec3> out = tube.position;
    for (const glm::vec3& p : tube.position) out.emplace_back(across + p.y, 0.5f + along, p.z);
    return out;
  };
  std::vector<glm::uvec3> triangle = tube.triangle;
  std::vector<std::uint32_t> place = tube.place;
  const auto count = static_cast<std::uint32_t>(tube.position.size());
  for (const glm::uvec3& t : tube.triangle) triangle.push_back(t + count);
  for (const std::uint32_t p : tube.place) place.push_back(p + count);
  for (std::size_t v = 0; v < tube.position.size(); ++v) ASSERT_LT(tube.place[v], count);
  const auto crossed = with_second(-0.5f, 0.0f), deeper = with_second(-0.5f, 0.02f);
  const auto apart = with_second(0.5f, 0.0f);
  const SelfIntersection layered(crossed, triangle, place), separate(apart, triangle, place);
  EXPECT_GT(layered.pairs(deeper).size(), 0u);
  EXPECT_EQ(layered.new_pairs(deeper).size(), 0u);
  EXPECT_GT(separate.new_pairs(deeper).size(), 0u);
}

TEST(SelfIntersection, WithinRigidGroupsIsNeverNewAndAcrossThemStillFound) {
  const ClosedTube tube(60, 12);
  std::vector<int> group;
  for (const glm::vec3& p : tube.position) group.push_back(p.y < 0.3f ? 0 : p.y > 0.7f ? 1 : -1);
  const SelfIntersection whole(tube.position, tube.triangle, tube.place);
  const SelfIntersection grouped(tube.position, tube.triangle, tube.place, group);
  // The middle bends over a circle, the ends go on straight, and cross.
  const auto posed = [&](double turn) {
    std::vector<glm::vec3> out;
    for (const glm::vec3& p : tube.position) {
      const double length = 0.4, radius = length / turn;
      const double s = std::clamp((p.y - 0.3) / length, 0.0, 1.0), angle = turn * s;
      const double beyond = p.y < 0.3f ? p.y - 0.3 : p.y > 0.7f ? p.y - 0.7 : 0.0;
      out.emplace_back(p.x, (radius + p.z) * std::sin(angle) + beyond * std::cos(angle),
                       radius - (radius + p.z) * std::cos(angle) + beyond * std::sin(angle));
    }
    return out;
  };
  EXPECT_EQ(whole.new_pairs(posed(1.0)).size(), 0u);
  const auto crossed = posed(3.6);
  EXPECT_GT(whole.new_pairs(crossed).size(), 0u);
  EXPECT_EQ(grouped.new_pairs(crossed), whole.new_pairs(crossed));
}

TEST(SelfIntersection, OfNothingIsNothing) {
  const SelfIntersection mesh({}, {}, {});
  EXPECT_EQ(mesh.measure({}).pairs, 0u);
  EXPECT_EQ(mesh.measure({}).area, 0.0);
}

}  // namespace
}  // namespace backbend::validate
