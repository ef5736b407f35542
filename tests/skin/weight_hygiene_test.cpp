// Every kind of dirt is found where it was put, and a clean figure has none.
#include "skin/weight_hygiene.h"

#include <gtest/gtest.h>

#include <glm/gtc/matrix_inverse.hpp>

#include "skin/driver_coverage.h"
#include "tests/skin/stick_figure.h"

namespace backbend::skin {
namespace {

/// The stick figure's skeleton under one curtain of 21 x 21 places in the X-Y plane, x from -1 to
/// 1, mirrored about x = 0, the weights shared by the two clavicles: all left at x = 1, all right
/// at x = -1. No other vertices.
Character curtain() {
  Character character = stick_figure();
  const auto left = static_cast<std::uint16_t>(stick_node(character, "clavicle.L"));
  const auto right = static_cast<std::uint16_t>(stick_node(character, "clavicle.R"));
  character.joints.clear();
  for (std::size_t n = 0; n < character.nodes.size(); ++n)  // one joint for each node
    character.joints.push_back(
        {static_cast<int>(n), glm::affineInverse(character.nodes[n].world_from_node)});
  character.bind_position.clear();
  character.bind_normal.clear();
  character.influences.clear();
  character.triangles.clear();
  character.place.clear();
  for (std::uint32_t row = 0; row < 21; ++row)
    for (std::uint32_t column = 0; column < 21; ++column) {
      const float x = 0.1f * (static_cast<float>(column) - 10.0f);
      character.bind_position.emplace_back(x, 0.1f * static_cast<float>(row), 0.0f);
      character.bind_normal.emplace_back(0.0f, 0.0f, 1.0f);
      character.place.push_back(row * 21 + column);
      const float share = 0.5f + 0.5f * x;
      Influences influences;
      const bool left_first = share >= 0.5f;
      influences.joint[0] = left_first ? left : right;
      influences.joint[1] = left_first ? right : left;
      influences.weight[0] = left_first ? share : 1.0f - share;
      influences.weight[1] = 1.0f - influences.weight[0];
      character.influences.push_back(influences);
      if (row == 0 || column == 0) continue;
      const std::uint32_t v = row * 21 + column;
      character.triangles.emplace_back(v - 22, v - 21, v);
      character.triangles.emplace_back(v - 22, v, v - 1);
    }
  character.place_count = 441;
  return character;
}

WeightHygiene judge(const Character& character) {
  const Anatomy anatomy = find_anatomy(character);
  return judge_weights(character, anatomy);
}

TEST(WeightHygiene, FindsNothingOnACleanCharacter) {
  const WeightHygiene weights = judge(curtain());
  EXPECT_EQ(weights.most_influences(), 2);
  EXPECT_EQ(weights.unweighted + weights.off_sum + weights.tiny + weights.more_than_four, 0u);
  EXPECT_DOUBLE_EQ(weights.mirrored_share, 1.0);
  EXPECT_EQ(weights.asymmetric, 0u);
  EXPECT_LT(weights.worst_asymmetry, 1e-6);
  EXPECT_TRUE(weights.bleed.empty());
}

TEST(WeightHygiene, FindsTheVertexThatDiffersFromItsMirrorImage) {
  Character character = curtain();
  character.influences[25].weight = {0.5f, 0.5f};  // column 4: was 0.8 right, 0.2 left
  const WeightHygiene weights = judge(character);
  EXPECT_EQ(weights.asymmetric, 2u);  // it and its image
  EXPECT_NEAR(weights.worst_asymmetry, 0.3, 1e-6);
  EXPECT_TRUE(weights.worst_asymmetric_vertex == 25 || weights.worst_asymmetric_vertex == 37);
}

TEST(WeightHygiene, FindsAnIslandOfWeightAwayFromTheJointsArea) {
  Character character = curtain();
  const auto foot = static_cast<std::uint16_t>(stick_node(character, "foot.L"));
  for (const std::size_t v : {0u, 1u, 2u}) {  // its area, a corner of the curtain
    character.influences[v].joint = {foot};
    character.influences[v].weight = {1.0f};
  }
  EXPECT_TRUE(judge(character).bleed.empty());
  character.influences[430].joint[2] = foot;  // one vertex at the other end
  character.influences[430].weight = {0.5f, 0.3f, 0.2f};
  const WeightHygiene weights = judge(character);
  ASSERT_EQ(weights.bleed.size(), 1u);
  EXPECT_EQ(weights.bleed[0].node, stick_node(character, "foot.L"));
  EXPECT_EQ(weights.bleed[0].places, 1u);
  EXPECT_EQ(weights.bleed[0].vertex, 430u);
  EXPECT_FLOAT_EQ(weights.bleed[0].largest, 0.2f);
}

TEST(WeightHygiene, CallsAJointOnTwoShellsNoBleed) {
  // Teeth and skin on one jaw: separate shells each have their own area.
  Character character = curtain();
  const auto count = static_cast<std::uint32_t>(character.vertex_count());
  Character twice = character;
  for (std::uint32_t v = 0; v < count; ++v) {
    twice.bind_position.push_back(character.bind_position[v] + glm::vec3(0.0f, 0.0f, 1.0f));
    twice.bind_normal.push_back(character.bind_normal[v]);
    twice.influences.push_back(character.influences[v]);
    twice.place.push_back(count + v);
  }
  for (const glm::uvec3& triangle : character.triangles)
    twice.triangles.push_back(triangle + count);
  twice.place_count = 2 * count;
  EXPECT_TRUE(judge(twice).bleed.empty());
}

TEST(WeightHygiene, CountsTinyWeightsAndLongLists) {
  Character character = curtain();
  character.influences[40].joint = {0, 1, 2, 3, 4};
  character.influences[40].weight = {0.5f, 0.2f, 0.2f, 0.095f, 0.005f};
  character.unweighted = {7};
  const WeightHygiene weights = judge(character);
  EXPECT_EQ(weights.tiny, 1u);
  EXPECT_EQ(weights.more_than_four, 1u);
  EXPECT_EQ(weights.most_influences(), 5);
  EXPECT_EQ(weights.unweighted, 1u);
  EXPECT_EQ(weights.with_influences[0], 1u);
}

TEST(DriverCoverage, SaysHowMuchOfTheTorsoHelpersHold) {
  Character character = stick_figure();
  const int spine = stick_node(character, "spine_1");
  Node helper = character.nodes[static_cast<std::size_t>(spine)];
  helper.name = "belly_fix";
  helper.parent = spine;
  helper.parent_from_node = glm::dmat4(1.0);
  character.nodes.push_back(helper);
  const int node = static_cast<int>(character.nodes.size()) - 1;
  const Anatomy before = find_anatomy(character);
  EXPECT_TRUE(driver_coverage(character, before).helpers.empty());  // it weighs nothing yet
  stick_vertex(character, node);
  const Anatomy anatomy = find_anatomy(character);
  const DriverCoverage coverage = driver_coverage(character, anatomy);
  EXPECT_EQ(coverage.helpers, std::vector<int>{node});
  // hips, spine_1, spine_2 and the helper each move three vertices of the torso.
  EXPECT_NEAR(coverage.helper_share, 0.25, 1e-12);
  EXPECT_TRUE(coverage.unreached.empty());
}

}  // namespace
}  // namespace backbend::skin
