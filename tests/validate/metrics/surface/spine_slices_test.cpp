#include "validate/metrics/surface/spine_slices.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "tests/validate/tube_fixture.h"
#include "validate/metrics/surface/connected_pieces.h"

namespace backbend::validate {
namespace {

using testing::even_bend;
using testing::SlicedTube;
using testing::Tube;

double polygon_area(double radius, int sides) {
  return 0.5 * sides * radius * radius * std::sin(2.0 * kPi / sides);
}

TEST(SpineLine, RunsThroughItsEndsAndAlongAStraightChain) {
  const std::vector<glm::dvec3> joints{{0, 0, 0}, {0, 1, 0}, {0, 4, 0}};
  const SpineLine line(joints);
  EXPECT_NEAR(line.length(), 4.0, 1e-12);
  for (double s : {-0.2, 0.0, 0.25, 0.7, 1.0, 1.3}) {
    EXPECT_NEAR(glm::distance(line.point(s), glm::dvec3(0, 4 * s, 0)), 0.0, 1e-6) << s;
    EXPECT_NEAR(line.foot({0.3, 4 * s, -0.2}).s, s, 1e-6) << s;
  }
}

TEST(SpineLine, AFootIsWhereThePlaneSquareToTheLineHoldsThePoint) {
  const std::vector<glm::dvec3> joints{{0, 0, 0}, {0, 1, 0.1}, {0, 2, 0.5}, {0, 2.7, 1.2}};
  const SpineLine line(joints);
  for (double s = 0.0; s <= 1.0; s += 0.05) {
    const glm::dvec3 across = glm::normalize(glm::cross(line.tangent(s), glm::dvec3(1, 0, 0)));
    for (double away : {-0.3, 0.0, 0.3}) {
      const SpineLine::Foot foot = line.foot(line.point(s) + away * across);
      EXPECT_NEAR(foot.s, s, 2e-3) << s << " away " << away;
      EXPECT_TRUE(foot.sure);
    }
  }
}

TEST(SpineLine, DeepInsideABendAFootIsNotSure) {
  std::vector<glm::dvec3> joints;  // a half circle of radius 1
  for (int i = 0; i <= 12; ++i)
    joints.push_back({0, std::sin(kPi * i / 12), 1.0 - std::cos(kPi * i / 12)});
  const SpineLine line(joints);
  EXPECT_TRUE(line.foot({0, -0.1, 0.6}).sure);
  EXPECT_FALSE(line.foot({0, 0.05, 0.95}).sure);
}

TEST(SpineCoordinate, WhereAFootIsNotSureIsTheMeanOfTheNeighbours) {
  std::vector<glm::dvec3> joints;  // a half circle of radius 1 about (0, 0, 1)
  for (int i = 0; i <= 12; ++i)
    joints.push_back({0, std::sin(kPi * i / 12), 1.0 - std::cos(kPi * i / 12)});
  const SpineLine line(joints);
  // Two vertices near the centre, side by side, and a rim of five on the body around them.
  std::vector<glm::vec3> position{{0, 0.05f, 0.95f}, {0, 0.02f, 1.04f}};
  for (const double turn : {0.4, 0.9, 1.5, 2.2, 2.9})
    position.emplace_back(0.05, 1.1 * std::sin(turn), 1.0 - 1.1 * std::cos(turn));
  const std::vector<glm::uvec3> triangle{{0, 2, 3}, {0, 3, 4}, {0, 4, 1}, {1, 4, 5}, {1, 5, 6}};
  const std::vector<glm::vec3> normal(7, glm::vec3(1, 0, 0));
  const std::vector<std::uint32_t> place{0, 1, 2, 3, 4, 5, 6};
  const std::vector<std::uint8_t> torso(7, 1);
  const std::vector<float> s =
      spine_coordinate({position, normal, triangle, place, 7, torso, {}, joints}, line);
  for (int v = 2; v < 7; ++v) EXPECT_NEAR(s[v], line.foot(glm::dvec3(position[v])).s, 1e-6) << v;
  EXPECT_NEAR(s[0], (s[1] + s[2] + s[3] + s[4]) / 4.0, 1e-5);
  EXPECT_NEAR(s[1], (s[0] + s[4] + s[5] + s[6]) / 4.0, 1e-5);
  EXPECT_GT(std::abs(s[0] - line.foot(glm::dvec3(position[0])).s), 0.02) << "nothing was relaxed";
}

TEST(CutSlices, OfATubeAreItsCrossSections) {
  const SlicedTube t(Tube(10));
  EXPECT_EQ(t.slices.measured(), 64u);
  for (int r = 0; r < 64; ++r) {
    const Slice& slice = t.slices.slice[r];
    EXPECT_NEAR(slice.s, 0.05 + 0.9 * r / 63, 1e-6);
    EXPECT_NEAR(t.rest_slices.area[r].y, polygon_area(0.1, 48), 1e-5);
    EXPECT_NEAR(glm::distance(t.rest_slices.centre[r], glm::dvec3(0, slice.s, 0)), 0.0, 1e-6);
    EXPECT_NEAR(t.rest_slices.direction[r].x, 1.0, 1e-4);
    double sum = 0.0;
    for (double w : slice.weight) sum += w;
    EXPECT_NEAR(sum, 1.0, 1e-12);
    EXPECT_NEAR(glm::dot(slice.line[0].offset, glm::dvec3(1, 0, 0)), 0.1, 1e-6);
    EXPECT_NEAR(glm::dot(slice.line[4].offset, glm::dvec3(0, 0, -1)), 0.1, 1e-6);
  }
}

TEST(CutSlices, PosedAreTheSameMaterial) {
  const SlicedTube t(Tube(10));
  const glm::dquat turn = rotation({0.3, -1.1, 0.7});
  std::vector<glm::vec3> moved;
  for (const glm::vec3& p : t.tube.position)
    moved.push_back(glm::vec3(turn * (2.0 * glm::dvec3(p)) + glm::dvec3(3, 4, 5)));
  const SlicePose pose = pose_slices(t.slices, moved);
  for (int r = 0; r < 64; ++r) {
    EXPECT_NEAR(glm::length(pose.area[r]), 4.0 * glm::length(t.rest_slices.area[r]), 1e-5);
    EXPECT_LT(
        glm::distance(pose.centre[r], turn * (2.0 * t.rest_slices.centre[r]) + glm::dvec3(3, 4, 5)),
        1e-5);
    EXPECT_LT(glm::distance(pose.direction[r], turn * t.rest_slices.direction[r]), 1e-4);
  }
}

TEST(CutSlices, DirectionLiesInTheSliceHoweverItIsBent) {
  const SlicedTube t(Tube(10));
  std::vector<glm::vec3> moved;  // rings lean, and are bent out of their planes
  for (const glm::vec3& p : t.tube.position)
    moved.emplace_back(p.x, p.y + 0.6f * p.x - 0.3f * p.z + 40.0f * p.x * p.x * p.x, p.z);
  const SlicePose pose = pose_slices(t.slices, moved);
  for (int r = 0; r < 64; ++r) {
    EXPECT_NEAR(glm::length(pose.direction[r]), 1.0, 1e-9);
    EXPECT_NEAR(glm::dot(pose.direction[r], glm::normalize(pose.area[r])), 0.0, 1e-9);
  }
}

TEST(CutSlices, WhereAnArmWasTakenOffTheRingIsClosedStraight) {
  Tube tube(10);
  for (std::size_t v = 0; v < tube.position.size(); ++v)  // a quarter of the tube, half way up
    if (tube.position[v].x > 0.1 * 0.7072 && std::abs(tube.position[v].y - 0.5) < 0.1)
      tube.torso[v] = 0;
  const SlicedTube t(std::move(tube));
  const SlicedTube whole(Tube(10));
  const double full = polygon_area(0.1, 48);
  // The chord over a quarter cuts off r^2 (pi/4 - 1/2); the mask takes one more row of triangles.
  const double cut = 0.1 * 0.1 * (kPi / 4 - 0.5);
  EXPECT_NEAR(glm::length(t.rest_slices.area[31]), full - cut, 0.4 * cut);
  EXPECT_LT(glm::length(t.rest_slices.area[31]), full - 0.5 * cut);
  EXPECT_NEAR(glm::length(t.rest_slices.area[5]), full, 1e-6);
  bool gap = false;
  for (const LinePoint& point : t.slices.slice[31].line) gap = gap || !point.surface;
  EXPECT_TRUE(gap);
  EXPECT_TRUE(whole.slices.slice[31].line[0].surface);
}

TEST(CutSlices, OfABodyThatTheSpineStandsOutsideOfSayHowFarAndAreItsRingsWhereItIsNear) {
  for (const double away : {0.05, 0.12, 0.2}) {
    Tube tube(10);
    for (glm::vec3& p : tube.position) p.z += static_cast<float>(away);
    const SlicedTube t(std::move(tube));
    EXPECT_EQ(t.slices.measured(), away < 0.125 ? 64u : 0u) << away;
    const double outside = std::max(0.0, away - 0.1) / 0.1;
    for (const Slice& slice : t.slices.slice) EXPECT_NEAR(slice.outside, outside, 0.01) << away;
    if (t.slices.measured() == 0) continue;
    EXPECT_NEAR(glm::length(t.rest_slices.area[31]), polygon_area(0.1, 48), 1e-5) << away;
    EXPECT_GT(t.rest_slices.area[31].y, 0.0) << away;
  }
}

/// A tube to the left of the spine, and another of `radius` to its right, each 0.02 away from it.
SpineSlices with_a_tube_on_each_side(double radius) {
  Tube left(10), right(10, radius);
  const auto first = static_cast<std::uint32_t>(left.position.size());
  for (glm::vec3& p : left.position) p.x += 0.12f;
  for (const glm::vec3& p : right.position)
    left.position.push_back(p - glm::vec3(static_cast<float>(radius) + 0.02f, 0.0f, 0.0f));
  for (const glm::uvec3& t : right.triangle) left.triangle.push_back(t + first);
  for (const std::uint32_t place : right.place) left.place.push_back(place + first);
  left.normal.insert(left.normal.end(), right.normal.begin(), right.normal.end());
  left.torso.insert(left.torso.end(), right.torso.begin(), right.torso.end());
  left.weight.insert(left.weight.end(), right.weight.begin(), right.weight.end());
  const RestMesh mesh = left.mesh();
  const SpineLine line(left.spine);
  return cut_slices(mesh, line, spine_coordinate(mesh, line), {1, 0, 0}, 64);
}

TEST(CutSlices, ASpineBetweenTwoLegsIsNotOutsideTheBody) {
  const SpineSlices legs = with_a_tube_on_each_side(0.1);
  EXPECT_EQ(legs.measured(), 0u);
  for (const Slice& slice : legs.slice) EXPECT_TRUE(std::isnan(slice.outside));
  // A hand beside a body is not a second leg.
  const SpineSlices body = with_a_tube_on_each_side(0.05);
  EXPECT_EQ(body.measured(), 64u);
  for (const Slice& slice : body.slice) EXPECT_NEAR(slice.outside, 0.2, 0.01);
}

TEST(CutSlices, ALegBesideTheSpineIsNoSlice) {
  Tube tube(10);
  for (glm::vec3& p : tube.position) p.x += 0.12f;
  const std::vector<float> moved_by_the_leg(tube.position.size(), 0.1f);
  RestMesh mesh = tube.mesh();
  mesh.spine_share = moved_by_the_leg;
  const SpineLine line(tube.spine);
  const SpineSlices slices = cut_slices(mesh, line, spine_coordinate(mesh, line), {1, 0, 0}, 64);
  EXPECT_EQ(slices.measured(), 0u);
}

TEST(CutSlices, ARingBesideTheSpineIsNoSlice) {
  Tube tube(10);
  for (glm::vec3& p : tube.position) p.x += 0.5f;  // like a leg
  const SlicedTube t(std::move(tube));
  EXPECT_EQ(t.slices.measured(), 0u);
  EXPECT_TRUE(std::isnan(t.rest_slices.centre[10].x));
  const SliceMeasures m = t.measure(t.tube.position, no_intent(t.slices, t.rest_slices));
  EXPECT_EQ(m.measured, 0u);
  EXPECT_TRUE(std::isnan(m.least_area_ratio));
  EXPECT_TRUE(std::isnan(m.kink_worst_deg));
  EXPECT_TRUE(std::isnan(m.folded));
}

TEST(CutSlices, DoNotDependOnHowVerticesAreSplitOrOrdered) {
  const SlicedTube plain(Tube(10));
  Tube tube(10);
  const std::size_t count = tube.position.size();  // every triangle gets vertices of its own
  Tube split = tube;
  split.position.clear();
  split.normal.clear();
  split.place.clear();
  split.torso.clear();
  split.weight.clear();
  std::uint32_t next = 0;
  for (glm::uvec3& t : split.triangle)
    for (int i = 0; i < 3; ++i) {
      split.position.push_back(tube.position[t[i]]);
      split.normal.push_back(tube.normal[t[i]]);
      split.place.push_back(t[i]);
      split.torso.push_back(1);
      split.weight.push_back(tube.weight[t[i]]);
      t[i] = next++;
    }
  RestMesh mesh = split.mesh();
  mesh.place_count = static_cast<std::uint32_t>(count);
  const SpineLine line(split.spine);
  const auto coordinate = spine_coordinate(mesh, line);
  const SpineSlices slices = cut_slices(mesh, line, coordinate, {1, 0, 0}, 64);
  const SlicePose pose = pose_slices(slices, split.position);
  for (int r = 0; r < 64; ++r) {
    EXPECT_EQ(slices.slice[r].ring.size(), plain.slices.slice[r].ring.size());
    EXPECT_LT(glm::distance(pose.area[r], plain.rest_slices.area[r]), 1e-9);
  }
}

/// The slices of a tube of 48 sides to which a second surface is added, whose vertices are its own
/// and stand at the tube's places: each `step`th column of them, its triangles turned inside out on
/// request.
SpineSlices with_a_second_surface(int step, bool inside_out) {
  Tube tube(10);
  const auto first = static_cast<std::uint32_t>(tube.position.size());
  const int columns = tube.sides / step;
  for (int r = 0; r <= tube.rings; ++r)
    for (int k = 0; k < columns; ++k) {
      const auto twin = static_cast<std::uint32_t>(r * tube.sides + k * step);
      tube.place.push_back(twin);
      tube.position.push_back(glm::vec3(tube.position[twin]));
      tube.normal.push_back(glm::vec3(tube.normal[twin]));
      tube.torso.push_back(1);
    }
  const auto at = [&](int r, int k) {
    return first + static_cast<std::uint32_t>(r * columns + k % columns);
  };
  for (int r = 0; r < tube.rings; ++r)
    for (int k = 0; k < columns; ++k)
      for (glm::uvec3 t : {glm::uvec3(at(r, k), at(r, k + 1), at(r + 1, k)),
                           glm::uvec3(at(r, k + 1), at(r + 1, k + 1), at(r + 1, k))}) {
        if (inside_out) std::swap(t.y, t.z);
        tube.triangle.push_back(t);
      }
  // An exporter orders triangles as it likes.
  std::ranges::shuffle(tube.triangle, std::mt19937(7));
  RestMesh mesh = tube.mesh();
  mesh.place_count = first;
  const SpineLine line(tube.spine);
  return cut_slices(mesh, line, spine_coordinate(mesh, line), {1, 0, 0}, 64);
}

TEST(SpineSlices, ASurfaceDoubledForItsBackFaceOrAsALevelOfDetailLeavesTheBodysRing) {
  const SlicedTube plain(Tube(10));
  for (const int step : {1, 2, 4, 8})
    for (const bool inside_out : {false, true}) {
      const SpineSlices slices = with_a_second_surface(step, inside_out);
      for (int r = 0; r < 64; ++r)
        EXPECT_EQ(slices.slice[r].ring.size(), plain.slices.slice[r].ring.size())
            << "every column of " << step << ", slice " << r;
    }
}

TEST(SpineSlices, GoRoundABodyWithAWallInItsMiddleWhereHalvesWereMirrored) {
  const SlicedTube plain(Tube(10));
  for (const bool own_vertices : {false, true})  // as with flat shading
    for (const int aside : {0, 5}) {             // the wall off the middle
      Tube tube(10);
      const auto places = static_cast<std::uint32_t>(tube.position.size());
      const auto at = [&](int r, int k) {
        const auto v = static_cast<std::uint32_t>(r * tube.sides + k);
        if (!own_vertices) return v;
        tube.place.push_back(v);
        tube.position.push_back(glm::vec3(tube.position[v]));
        tube.normal.emplace_back(1, 0, 0);
        tube.torso.push_back(1);
        return static_cast<std::uint32_t>(tube.position.size()) - 1;
      };
      const int front = tube.sides / 4 - aside, back = 3 * tube.sides / 4 + aside;
      for (int r = 0; r < tube.rings; ++r) {
        tube.triangle.emplace_back(at(r, front), at(r, back), at(r + 1, front));
        tube.triangle.emplace_back(at(r, back), at(r + 1, back), at(r + 1, front));
      }
      std::ranges::shuffle(tube.triangle, std::mt19937(7));
      RestMesh mesh = tube.mesh();
      mesh.place_count = places;
      const SpineLine line(tube.spine);
      const SpineSlices slices =
          cut_slices(mesh, line, spine_coordinate(mesh, line), {1, 0, 0}, 64);
      for (int r = 0; r < 64; ++r)
        EXPECT_EQ(slices.slice[r].ring.size(), plain.slices.slice[r].ring.size())
            << "slice " << r << (own_vertices ? ", own vertices" : "") << ", aside by " << aside;
    }
}

/// Two half tubes, each closed by a wall of its own that stands beside the middle, to its own side
/// or past it.
TEST(SpineSlices, KnowHalvesThatWereMirroredAndNotJoined) {
  constexpr int kRows = 40, kArc = 13;
  for (const double wall : {-0.004, 0.004}) {
    Tube tube(10);
    const std::vector<glm::dvec3> spine = tube.spine;
    tube.position.clear(), tube.normal.clear(), tube.triangle.clear(), tube.place.clear();
    tube.torso.clear();
    for (const double side : {1.0, -1.0}) {
      const auto first = static_cast<std::uint32_t>(tube.position.size());
      for (int r = 0; r <= kRows; ++r)
        for (int k = 0; k < kArc; ++k) {
          const double angle = kPi * (static_cast<double>(k) / (kArc - 1) - 0.5);
          tube.place.push_back(static_cast<std::uint32_t>(tube.position.size()));
          tube.position.emplace_back(side * (wall + 0.1 * std::cos(angle)),
                                     static_cast<double>(r) / kRows, 0.1 * std::sin(angle));
          tube.normal.emplace_back(side, 0, 0);
          tube.torso.push_back(1);
        }
      const auto at = [&](std::uint32_t r, std::uint32_t k) { return first + r * kArc + k % kArc; };
      for (std::uint32_t r = 0; r < kRows; ++r)
        for (std::uint32_t k = 0; k < kArc; ++k) {
          tube.triangle.emplace_back(at(r, k), at(r, k + 1), at(r + 1, k));
          tube.triangle.emplace_back(at(r, k + 1), at(r + 1, k + 1), at(r + 1, k));
        }
    }
    const RestMesh mesh = tube.mesh();
    const SpineLine line(spine);
    const SpineSlices slices = cut_slices(mesh, line, spine_coordinate(mesh, line), {1, 0, 0}, 16);
    for (const Slice& slice : slices.slice) {
      if (slice.ring.empty()) continue;
      EXPECT_TRUE(slice.is_half) << wall << ' ' << slice.s;
    }
    EXPECT_EQ(slices.measured() > 0, wall < 0.0);  // else the spine is between the legs
  }
  for (const Slice& slice : SlicedTube(Tube(10)).slices.slice) EXPECT_FALSE(slice.is_half);
}

/// How many of 64 slices take a band of twice the tube's radius that lies around it from `from` to
/// `to`, and of which `joint_at` moves the place at a height.
template <typename JointAt>
int slices_of_band(double from, double to, const JointAt& joint_at) {
  constexpr int kRows = 8, kSides = 24;
  Tube tube(10);
  std::vector<int> joint(tube.position.size(), -1);
  const auto first = static_cast<std::uint32_t>(tube.position.size());
  for (int r = 0; r <= kRows; ++r)
    for (int k = 0; k < kSides; ++k) {
      const double angle = 2.0 * kPi * k / kSides, height = from + (to - from) * r / kRows;
      tube.place.push_back(static_cast<std::uint32_t>(tube.position.size()));
      tube.position.emplace_back(0.2 * std::cos(angle), height, -0.2 * std::sin(angle));
      tube.normal.emplace_back(std::cos(angle), 0, -std::sin(angle));
      tube.torso.push_back(1);
      joint.push_back(joint_at(height));
    }
  for (std::uint32_t r = 0; r < kRows; ++r)
    for (std::uint32_t k = 0; k < kSides; ++k) {
      const std::uint32_t a = first + r * kSides + k, b = first + r * kSides + (k + 1) % kSides;
      tube.triangle.push_back({a, b, a + kSides});
      tube.triangle.push_back({b, b + kSides, a + kSides});
    }
  RestMesh mesh = tube.mesh();
  const SpineLine line(tube.spine);
  const std::vector<float> coordinate = spine_coordinate(mesh, line);
  std::vector<double> fraction;
  for (int k = 0; k <= 10; ++k) fraction.push_back(0.1 * k);
  const std::vector<std::uint8_t> rigid =
      rigid_pieces(tube.triangle, tube.place, joint, fraction, coordinate);
  mesh.rigid = rigid;
  const SpineSlices slices = cut_slices(mesh, line, coordinate, {1, 0, 0}, 64);
  EXPECT_EQ(slices.measured(), 64u);
  return static_cast<int>(std::ranges::count_if(
      slices.slice, [&](const Slice& slice) { return slice.ring.front().a >= first; }));
}

TEST(SpineSlices, TheBodyBelowAPlateThatGoesWithTheJointNearItIsMeasured) {
  EXPECT_EQ(slices_of_band(0.4, 0.9, [](double) { return 8; }), 0);
  EXPECT_EQ(slices_of_band(-0.1, 0.1, [](double) { return 0; }), 0);
}

TEST(SpineSlices, ACostumeThatBendsOrHangsFromAFarJointIsMeasuredItself) {
  EXPECT_GT(slices_of_band(0.4, 0.9, [](double height) { return height < 0.6 ? 6 : 8; }), 30);
  EXPECT_GT(slices_of_band(0.4, 0.9, [](double height) { return height < 0.6 ? -1 : 8; }), 30);
  EXPECT_GT(slices_of_band(0.1, 0.9, [](double) { return 8; }), 50);     // a whole shirt
  EXPECT_GT(slices_of_band(0.05, 0.25, [](double) { return 10; }), 10);  // a belt on the chest
}

}  // namespace
}  // namespace backbend::validate
