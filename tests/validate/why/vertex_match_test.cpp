#include "validate/why/vertex_match.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>

namespace backbend::validate {
namespace {

/// A grid of `n` x `n` vertices with two triangles a cell.
struct Sheet {
  std::vector<glm::vec3> position;
  std::vector<glm::uvec3> triangles;

  explicit Sheet(unsigned n) {
    for (unsigned y = 0; y < n; ++y)
      for (unsigned x = 0; x < n; ++x)
        position.emplace_back(static_cast<float>(x), static_cast<float>(y),
                              0.1f * static_cast<float>(x * y % 3));
    for (unsigned y = 0; y + 1 < n; ++y)
      for (unsigned x = 0; x + 1 < n; ++x) {
        const unsigned a = y * n + x, b = a + 1, c = a + n, d = c + 1;
        triangles.emplace_back(a, b, d);
        triangles.emplace_back(a, d, c);
      }
  }
  RestSurface surface() const { return {position, triangles}; }
};

/// The same surface under other numbers; `number[v]` is v's new one.
Sheet renumbered(const Sheet& from, const std::vector<unsigned>& number) {
  Sheet out = from;
  for (std::size_t v = 0; v < number.size(); ++v) out.position[number[v]] = from.position[v];
  for (glm::uvec3& t : out.triangles)
    t = {number[t.y], number[t.z], number[t.x]};  // begun at another corner
  std::ranges::reverse(out.triangles);
  return out;
}

std::vector<unsigned> shuffled(std::size_t count) {
  std::vector<unsigned> number(count);
  std::iota(number.begin(), number.end(), 0u);
  std::mt19937 rng(7);
  for (std::size_t i = count; i-- > 1;) std::swap(number[i], number[rng() % (i + 1)]);
  return number;
}

constexpr MatchReach kReach{0.05, 1e-4, 0.9};

TEST(VertexMatch, VerticesThatWereMovedAndRenumberedKeepTheirPartners) {
  const Sheet before(12);
  const std::vector<unsigned> number = shuffled(before.position.size());
  Sheet after = renumbered(before, number);
  // A belt is moved so far that each of its vertices is closest to where another one stood.
  for (std::size_t v = 0; v < before.position.size(); ++v)
    if (before.position[v].y > 3.5f && before.position[v].y < 8.5f)
      after.position[number[v]].x += 0.7f;
  const VertexMatch match = match_vertices(before.surface(), after.surface(), kReach);
  EXPECT_TRUE(match.same_mesh);
  EXPECT_EQ(match.coverage, 1.0);
  for (std::size_t v = 0; v < number.size(); ++v) {
    EXPECT_EQ(match.after_of_before[v], number[v]) << v;
    EXPECT_EQ(match.before_of_after[number[v]], v) << v;
  }
}

TEST(VertexMatch, CopiesOfAPlaceAreToldApartByTheirTriangles) {
  // Two sheets back to back on the same vertices' places.
  Sheet before(5);
  const auto count = static_cast<unsigned>(before.position.size());
  const std::vector<glm::uvec3> front = before.triangles;
  for (unsigned v = 0; v < count; ++v) before.position.push_back(before.position[v]);
  for (const glm::uvec3& t : front)
    before.triangles.emplace_back(count + t.x, count + t.z, count + t.y);
  // One vertex of each that stands alone tells which is which.
  before.position[0].z += 1.0f;
  before.position[count].z -= 1.0f;
  before.position[1].z += 1.0f;
  before.position[count + 1].z -= 1.0f;
  const std::vector<unsigned> number = shuffled(before.position.size());
  const Sheet after = renumbered(before, number);
  const VertexMatch match = match_vertices(before.surface(), after.surface(), kReach);
  EXPECT_TRUE(match.same_mesh);
  for (std::size_t v = 0; v < number.size(); ++v) EXPECT_EQ(match.after_of_before[v], number[v]);
}

/// The sheet cut along a column of vertices, as an export splits them at a seam of its texture:
/// cells right of `column` have copies of their own, `copy_of` says whose.
Sheet split(const Sheet& from, unsigned n, unsigned column, std::vector<unsigned>& copy_of) {
  Sheet out = from;
  copy_of.resize(from.position.size());
  std::iota(copy_of.begin(), copy_of.end(), 0u);
  std::vector<unsigned> right(from.position.size());
  std::iota(right.begin(), right.end(), 0u);
  for (unsigned y = 0; y < n; ++y) {
    const unsigned v = y * n + column;
    right[v] = static_cast<unsigned>(out.position.size());
    out.position.push_back(from.position[v]);
    copy_of.push_back(v);
  }
  for (glm::uvec3& t : out.triangles) {
    const auto is_right = [&](unsigned v) { return v % n > column; };
    if (is_right(t.x) || is_right(t.y) || is_right(t.z)) t = {right[t.x], right[t.y], right[t.z]};
  }
  return out;
}

TEST(VertexMatch, VerticesThatAnExportSplitAndMovedHaveTheirPartners) {
  constexpr unsigned n = 12;
  const Sheet whole(n);
  std::vector<unsigned> copy_of;
  Sheet cut = split(whole, n, 5, copy_of);
  for (std::size_t v = 0; v < cut.position.size(); ++v)
    if (cut.position[v].y > 3.5f && cut.position[v].y < 8.5f) cut.position[v].x += 0.7f;
  const VertexMatch match = match_vertices(whole.surface(), cut.surface(), kReach);
  EXPECT_FALSE(match.same_mesh);
  EXPECT_EQ(match.coverage, 1.0);
  for (std::size_t v = 0; v < copy_of.size(); ++v)
    EXPECT_EQ(match.before_of_after[v], copy_of[v]) << v;
  // And the other way: merged again.
  const VertexMatch back = match_vertices(cut.surface(), whole.surface(), kReach);
  EXPECT_EQ(back.coverage, 1.0);
  for (std::size_t v = 0; v < copy_of.size(); ++v)
    EXPECT_EQ(back.after_of_before[v], copy_of[v]) << v;
}

TEST(VertexMatch, ACopyOfASplitVertexIsMatchedOnItsOwnSideOfTheSeam) {
  constexpr unsigned n = 8;
  const Sheet whole(n);
  std::vector<unsigned> once, twice;
  const Sheet one = split(whole, n, 3, once);  // copies 64.. belong to the cells on the right
  const Sheet two = split(one, n, 5, twice);   // cut again elsewhere: another count of vertices
  const VertexMatch match = match_vertices(one.surface(), two.surface(), kReach);
  for (unsigned y = 0; y < n; ++y) {
    EXPECT_EQ(match.before_of_after[y * n + 3], y * n + 3);
    EXPECT_EQ(match.before_of_after[n * n + y], n * n + y);
  }
}

TEST(VertexMatch, TrianglesThatWereCutTheOtherWayMisleadNobody) {
  constexpr unsigned n = 10;
  const Sheet before(n);
  Sheet after = before;
  for (std::size_t t = 0; t < after.triangles.size(); t += 2) {
    const unsigned a = after.triangles[t].x, b = a + 1, c = a + n, d = c + 1;
    if (a % 3 == 0) continue;
    after.triangles[t] = {a, b, c};
    after.triangles[t + 1] = {b, d, c};
  }
  // A patch is moved by less than a partner may be far: each one's closest rest point is itself.
  for (unsigned v = 0; v < n * n; ++v)
    if (v % n > 2 && v % n < 7 && v / n > 2 && v / n < 7) after.position[v].z += 0.04f;
  const VertexMatch match = match_vertices(before.surface(), after.surface(), kReach);
  EXPECT_EQ(match.coverage, 1.0);
  for (unsigned v = 0; v < n * n; ++v) EXPECT_EQ(match.before_of_after[v], v) << v;
}

TEST(VertexMatch, ARemeshThatSharesNoVertexIsMatchedByTheClosestRestPoint) {
  const Sheet before(9);
  Sheet after(9);
  for (glm::vec3& p : after.position) p += glm::vec3(0.03f, -0.02f, 0.0f);
  std::ranges::reverse(after.position);
  for (glm::uvec3& t : after.triangles) t = glm::uvec3(80u) - t;
  const VertexMatch match = match_vertices(before.surface(), after.surface(), kReach);
  EXPECT_EQ(match.coverage, 1.0);
  for (unsigned v = 0; v < 81; ++v) EXPECT_EQ(match.before_of_after[v], 80 - v);
}

TEST(VertexMatch, AnotherMeshIsMatchedByPlaceAndIsNotTheSame) {
  const Sheet before(6);
  Sheet after = before;
  after.position.emplace_back(0.5f, 0.5f, 0.0f);  // a vertex more, in the first cell
  after.triangles.front() = {0, 1, 36};
  const VertexMatch match = match_vertices(before.surface(), after.surface(), kReach);
  EXPECT_FALSE(match.same_mesh);
  EXPECT_LT(match.coverage, 1.0);
  EXPECT_GT(match.coverage, 0.9);
  for (unsigned v = 0; v < 36; ++v) EXPECT_EQ(match.before_of_after[v], v);
  EXPECT_LT(match.before_of_after[36], 36u);  // the nearest's
}

TEST(VertexMatch, BodiesWithNothingInCommonGetNoNumbers) {
  const Sheet before(6);
  Sheet after(7);
  for (glm::vec3& p : after.position) p += glm::vec3(0.3f, 0.3f, 5.0f);
  const VertexMatch match = match_vertices(before.surface(), after.surface(), kReach);
  EXPECT_EQ(match.coverage, 0.0);
  EXPECT_TRUE(match.before_of_after.empty());
}

}  // namespace
}  // namespace backbend::validate
