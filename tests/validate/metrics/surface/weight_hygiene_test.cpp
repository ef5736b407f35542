#include "validate/metrics/surface/weight_hygiene.h"

#include <gtest/gtest.h>

#include <glm/gtc/matrix_inverse.hpp>

namespace backbend::validate {
namespace {

/// A strip of a surface, 30 by 12 vertices, bound to a chain of six joints along it.
struct Strip {
  static constexpr std::uint32_t kLong = 30, kWide = 12;
  std::vector<skin::Influences> influences;
  std::vector<glm::uvec3> triangle;
  std::vector<std::uint32_t> place;

  Strip() {
    for (std::uint32_t y = 0; y < kLong; ++y)
      for (std::uint32_t x = 0; x < kWide; ++x) {
        const float along = 5.0f * static_cast<float>(y) / (kLong - 1);
        const auto below = static_cast<std::uint16_t>(std::min(along, 4.0f));
        skin::Influences i;
        i.joint = {below, static_cast<std::uint16_t>(below + 1)};
        i.weight = {1.0f - (along - below), along - below};
        influences.push_back(i);
        place.push_back(y * kWide + x);
      }
    for (std::uint32_t y = 0; y + 1 < kLong; ++y)
      for (std::uint32_t x = 0; x + 1 < kWide; ++x) {
        const std::uint32_t a = y * kWide + x;
        triangle.push_back({a, a + 1, a + kWide});
        triangle.push_back({a + 1, a + kWide + 1, a + kWide});
      }
  }
  WeightHygiene examine() const {
    return examine_weights(influences, triangle, place, kLong * kWide);
  }
  void bind(std::uint32_t vertex, std::uint16_t joint, float weight = 1.0f) {
    skin::Influences i;
    i.joint = {joint, influences[vertex].joint[0]};
    i.weight = {weight, 1.0f - weight};
    influences[vertex] = i;
  }
};

TEST(ExamineWeights, SmoothWeightsAreClean) {
  const WeightHygiene h = Strip().examine();
  EXPECT_LT(h.worst_sum, 1e-6);
  EXPECT_EQ(h.unweighted, 0u);
  EXPECT_EQ(h.stray, 0u);
}

TEST(ExamineWeights, OneVertexBoundToAFarJointIsNamed) {
  Strip strip;
  strip.bind(100, 5);
  const WeightHygiene h = strip.examine();
  EXPECT_EQ(h.stray, 1u);
  EXPECT_EQ(h.stray_vertex, 100);
  EXPECT_NEAR(h.stray_weight, 1.0, 1e-6);
}

TEST(ExamineWeights, HalfOfAVertexIsEnoughAndLessIsNot) {
  Strip strip;
  strip.bind(100, 5, 0.6f);
  EXPECT_EQ(strip.examine().stray, 1u);
  Strip less;
  less.bind(100, 5, 0.4f);
  EXPECT_EQ(less.examine().stray, 0u);
  Strip half;  // and what 8 bits make of it
  half.bind(100, 5, 128.0f / 255.0f);
  EXPECT_EQ(half.examine().stray, 0u);
}

TEST(ExamineWeights, AHardBorderIsNoStray) {
  Strip strip;  // the right half on other joints, next to each other without a blend
  for (std::uint32_t v = 0; v < strip.influences.size(); ++v)
    if (v % Strip::kWide >= 6) strip.bind(v, 7);
  EXPECT_EQ(strip.examine().stray, 0u);
}

TEST(ExamineWeights, AStrayBetweenNeighboursWhoDisagreeIsFoundByTheRingAroundThem) {
  Strip strip;
  for (std::uint32_t v = 0; v < strip.influences.size(); ++v)
    if (v % Strip::kWide >= 6) strip.bind(v, 7);
  const std::uint32_t border = 10 * Strip::kWide + 6;
  strip.bind(border, 5);
  const WeightHygiene h = strip.examine();
  EXPECT_EQ(h.stray, 1u);
  EXPECT_EQ(h.stray_vertex, static_cast<int>(border));
  // Where somebody two rings away knows the joint it may be a patch: only that one is named.
  strip.bind(border + 2, 5);
  EXPECT_EQ(strip.examine().stray, 1u);
  EXPECT_EQ(strip.examine().stray_vertex, static_cast<int>(border) + 2);
}

TEST(ExamineWeights, TheTipOfALimbOnACoarseMeshIsNoStray) {
  Strip strip;
  // Joints 6 to 9 hang from joint 1 one after another: a toe's, say.
  const std::vector<int> parent = {-1, 0, 1, 2, 3, 4, 1, 6, 7, 8};
  const auto stray = [&] {
    return examine_weights(strip.influences, strip.triangle, strip.place,
                           Strip::kLong * Strip::kWide, parent)
        .stray;
  };
  const std::uint32_t by_joint_1 = 6 * Strip::kWide + 5;
  strip.bind(by_joint_1, 7);
  EXPECT_EQ(strip.examine().stray, 1u);  // nobody knows the skeleton
  EXPECT_EQ(stray(), 0u);
  strip.bind(by_joint_1, 9);  // four bones away
  EXPECT_EQ(stray(), 1u);
  strip.bind(by_joint_1, 5);  // it moves the far end of the strip
  EXPECT_EQ(stray(), 1u);
  strip.bind(by_joint_1, 3);  // two bones away, but with an area of its own
  EXPECT_EQ(stray(), 1u);
}

/// The strip as a character, its rows 2 apart along Y; joint k is node k, 10 * k along Y.
skin::Character character_of(const Strip& strip, const std::vector<int>& parent) {
  skin::Character character;
  for (std::size_t k = 0; k < parent.size(); ++k) {
    character.nodes.push_back({});
    character.nodes.back().parent = parent[k];
    glm::dmat4& world = character.nodes.back().world_from_node;
    world[3] = {0.0, 10.0 * static_cast<double>(k), 0.0, 1.0};
    character.joints.push_back({static_cast<int>(k), glm::affineInverse(world)});
  }
  character.triangles = strip.triangle;
  character.place = strip.place;
  character.place_count = Strip::kLong * Strip::kWide;
  for (std::uint32_t v = 0; v < character.place_count; ++v) {
    character.bind_position.emplace_back(v % Strip::kWide, 2 * (v / Strip::kWide), 0);
    character.bind_normal.emplace_back(0, 0, 1);
  }
  character.influences = strip.influences;
  return character;
}

TEST(ExamineWeights, WhatHangsFromTheHeadIsOneJoint) {
  Strip strip;
  // 3 is the head, from which 6 (jaw) and 7 (tongue) hang.
  const skin::Character character = character_of(strip, {-1, 0, 1, 2, 3, 4, 3, 3});
  for (std::uint32_t v = 0; v < strip.influences.size(); ++v) strip.bind(v, 6);
  strip.bind(100, 7);
  EXPECT_EQ(examine_weights(character, strip.influences).stray, 1u);
  EXPECT_EQ(examine_weights(character, strip.influences, 3).stray, 0u);
  strip.bind(100, 0);  // far below the head
  EXPECT_EQ(examine_weights(character, strip.influences, 3).stray, 1u);
}

TEST(ExamineWeights, AVertexNearerToItsJointThanToItsNeighboursIsNoStray) {
  Strip strip;
  const std::uint32_t vertex = 12 * Strip::kWide + 5;  // 24 up; joint 5 is at 50
  strip.bind(vertex, 5);
  skin::Character character = character_of(strip, {-1, 0, 1, 2, 3, 4});
  for (const float up : {24.0f, 35.0f}) {
    character.bind_position[vertex] = {0.2f, up, 0.0f};
    EXPECT_EQ(examine_weights(character, strip.influences).stray, 1u) << up;
  }
  for (const float up : {39.0f, 49.0f}) {  // drawn out over a coarse mesh to its joint
    character.bind_position[vertex] = {0.2f, up, 0.0f};
    EXPECT_EQ(examine_weights(character, strip.influences).stray, 0u) << up;
  }
  // Along the bone from joint 4, too.
  character.bind_position[vertex] = {0.2f, 45.0f, 0.0f};
  strip.bind(vertex, 4);
  EXPECT_EQ(examine_weights(character, strip.influences).stray, 0u);
}

TEST(ExamineWeights, SplitVerticesDoNotHideAStray) {
  Strip strip;
  const auto extra = static_cast<std::uint32_t>(strip.influences.size());
  strip.bind(100, 5);
  strip.influences.push_back(strip.influences[100]);
  strip.place.push_back(100);
  for (glm::uvec3& t : strip.triangle)
    if (t.x == 100) t.x = extra;
  EXPECT_EQ(strip.examine().stray, 1u);
}

TEST(ExamineWeights, SumsAndMissingWeightsAreCounted) {
  Strip strip;
  strip.influences[7].weight = {0.5f, 0.499f};
  strip.influences[9].weight = {};
  strip.influences[11].weight[0] = std::numeric_limits<float>::quiet_NaN();
  const WeightHygiene h = strip.examine();
  EXPECT_NEAR(h.worst_sum, 0.001, 1e-6);
  EXPECT_EQ(h.worst_sum_vertex, 7);
  EXPECT_EQ(h.unweighted, 2u);
  EXPECT_EQ(h.unweighted_vertex, 9);
}

}  // namespace
}  // namespace backbend::validate
