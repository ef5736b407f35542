// Every kind of dirt is found where it was put, and a clean figure has none.
#include "skin/weights/weight_hygiene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_inverse.hpp>
#include <random>

#include "skin/anatomy/driver_coverage.h"
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

TEST(WeightHygiene, LeavesPiecesOfACostumeAlone) {
  Character character = curtain();
  const auto foot = static_cast<std::uint16_t>(stick_node(character, "foot.L"));
  const auto bind = [&](std::size_t row, std::size_t column, float share) {
    Influences& influences = character.influences[row * 21 + column];
    const auto before = curtain().influences[row * 21 + column].joint;
    influences.joint = {foot, before[0], before[1]};  // the largest weight first
    influences.weight = {share, 0.5f * (1.0f - share), 0.5f * (1.0f - share)};
  };
  for (std::size_t row = 0; row < 6; ++row)  // its area
    for (std::size_t column = 0; column < 6; ++column) bind(row, column, 1.0f);
  // A plate that it holds all over, far from there.
  for (std::size_t row = 15; row < 18; ++row)
    for (std::size_t column = 12; column < 17; ++column) bind(row, column, 0.95f);
  EXPECT_TRUE(judge(character).bleed.empty());
  // The same patch half as firm was painted by accident.
  for (std::size_t row = 15; row < 18; ++row)
    for (std::size_t column = 12; column < 17; ++column) bind(row, column, 0.5f);
  ASSERT_EQ(judge(character).bleed.size(), 1u);
  EXPECT_EQ(judge(character).bleed[0].places, 15u);

  // As a part of its own whose vertices stand on the body's, it is a piece at any share.
  Character dressed = character;
  dressed.parts.push_back({"body", 0, 0, static_cast<std::uint32_t>(character.triangles.size()), 0,
                           static_cast<std::uint32_t>(character.vertex_count())});
  const auto first = static_cast<std::uint32_t>(character.vertex_count());
  for (std::size_t row = 15; row < 18; ++row)
    for (std::size_t column = 12; column < 17; ++column) {
      const std::size_t v = row * 21 + column;
      dressed.influences[v] = curtain().influences[v];
      dressed.bind_position.push_back(character.bind_position[v] + glm::vec3(0.0f, 0.0f, 0.1f));
      dressed.bind_normal.push_back(character.bind_normal[v]);
      dressed.influences.push_back(character.influences[v]);
      // Its first row touches the body.
      dressed.place.push_back(row == 15 ? character.place[v] : dressed.place_count++);
      if (row == 15 || column == 12) continue;
      const auto n = static_cast<std::uint32_t>(dressed.vertex_count()) - 1;
      dressed.triangles.emplace_back(n - 6, n - 5, n);
      dressed.triangles.emplace_back(n - 6, n, n - 1);
    }
  dressed.parts.push_back(
      {"plate", 0, dressed.parts[0].triangle_count,
       static_cast<std::uint32_t>(dressed.triangles.size()) - dressed.parts[0].triangle_count,
       first, static_cast<std::uint32_t>(dressed.vertex_count()) - first});
  EXPECT_TRUE(judge(dressed).bleed.empty());
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

/// The curtain with weights of any kind: patches of joints at random, its middle moved aside, its
/// places a little off their columns so that not each has an image.
Character painted(unsigned seed) {
  Character character = curtain();
  std::mt19937 rng(seed);
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  for (std::size_t v = 0; v < character.vertex_count(); ++v) {
    if (rng() % 4 == 0) character.bind_position[v].x += 0.02f * unit(rng);
    // A quarter of the distance at which a place is an image, to every side of the cells' borders.
    for (int axis = 0; axis < 3; ++axis)
      character.bind_position[v][axis] += 0.001f * static_cast<float>(rng() % 3) - 0.001f;
    if (rng() % 2 == 0) continue;
    Influences w;
    std::array<float, 4> share = {unit(rng), 0.2f * unit(rng), 0.1f * unit(rng), 0.03f * unit(rng)};
    std::sort(share.begin(), share.end(), std::greater<>());
    const float sum = share[0] + share[1] + share[2] + share[3];
    const std::size_t first = rng() % 5;
    for (std::size_t k = 0; k < 4; ++k) {
      w.joint[k] = static_cast<std::uint16_t>(first + 2 * k);
      w.weight[k] = share[k] / sum;
    }
    character.influences[v] = w;
  }
  return character;
}

double weight_on(const Character& character, std::size_t v, int node) {
  double sum = 0.0;
  for (std::size_t k = 0; k < kMaxInfluences; ++k)
    if (character.joints[character.influences[v].joint[k]].node == node)
      sum += character.influences[v].weight[k];
  return sum;
}

TEST(WeightHygiene, FindsTheIslandsThatAFloodFillFinds) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const Character character = painted(seed);
    const WeightHygiene weights = judge(character);
    std::vector<Bleed> expected;
    for (int node = 0; node < static_cast<int>(character.nodes.size()); ++node) {
      std::vector<int> island(character.vertex_count(), -1);
      std::vector<double> sum;
      const auto on = [&](std::size_t v) { return weight_on(character, v, node) > 0.01f; };
      for (std::size_t v = 0; v < island.size(); ++v) {
        if (!on(v) || island[v] >= 0) continue;
        std::vector<std::size_t> pending{v};
        island[v] = static_cast<int>(sum.size());
        sum.push_back(0.0);
        while (!pending.empty()) {
          const std::size_t at = pending.back();
          pending.pop_back();
          sum.back() += weight_on(character, at, node);
          for (const glm::uvec3& t : character.triangles) {
            if (t.x != at && t.y != at && t.z != at) continue;
            for (int k = 0; k < 3; ++k)
              if (on(t[k]) && island[t[k]] < 0) {
                island[t[k]] = island[at];
                pending.push_back(t[k]);
              }
          }
        }
      }
      if (sum.empty()) continue;
      const int main = static_cast<int>(std::max_element(sum.begin(), sum.end()) - sum.begin());
      Bleed all{node};
      for (int i = 0; i < static_cast<int>(sum.size()); ++i) {
        if (i == main) continue;
        std::size_t places = 0;
        double largest = 0.0;
        std::uint32_t vertex = 0;
        for (std::size_t v = 0; v < island.size(); ++v) {
          if (island[v] != i) continue;
          ++places;
          if (const double w = weight_on(character, v, node); w > largest)
            largest = w, vertex = static_cast<std::uint32_t>(v);
        }
        if (largest < 0.05f) continue;
        all.places += places;
        if (largest > static_cast<double>(all.largest))
          all.largest = static_cast<float>(largest), all.vertex = vertex;
      }
      if (all.places > 0) expected.push_back(all);
    }
    ASSERT_GT(expected.size(), 3u);
    ASSERT_EQ(weights.bleed.size(), expected.size());
    for (std::size_t i = 0; i < expected.size(); ++i) {
      EXPECT_EQ(weights.bleed[i].node, expected[i].node);
      EXPECT_EQ(weights.bleed[i].places, expected[i].places) << i;
      EXPECT_EQ(weights.bleed[i].largest, expected[i].largest);
      EXPECT_EQ(weights.bleed[i].vertex, expected[i].vertex);
    }
  }
}

TEST(WeightHygiene, ComparesEveryPlaceWithTheNearestToItsImage) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    const Character character = painted(seed);
    const Anatomy anatomy = find_anatomy(character);
    const WeightHygiene weights = judge_weights(character, anatomy);
    const double edge = 0.002 * anatomy.height;
    const auto swapped = [&](int node) {
      std::string name = character.nodes[static_cast<std::size_t>(node)].name;
      if (name.size() > 2 && name[name.size() - 2] == '.')
        name.back() = name.back() == 'L' ? 'R' : 'L';
      return stick_node(character, name);
    };
    std::size_t mirrored = 0, asymmetric = 0;
    double worst = 0.0;
    std::uint32_t worst_vertex = 0;
    for (std::size_t v = 0; v < character.vertex_count(); ++v) {
      const glm::dvec3 p(character.bind_position[v]), image(-p.x, p.y, p.z);
      double least = edge;
      std::size_t best = character.vertex_count();
      for (std::size_t w = 0; w < character.vertex_count(); ++w)
        if (const double d = glm::distance(image, glm::dvec3(character.bind_position[w]));
            d < least)
          least = d, best = w;
      if (best == character.vertex_count()) continue;
      ++mirrored;
      double difference = 0.0;
      for (int node = 0; node < static_cast<int>(character.nodes.size()); ++node)
        difference += 0.5 * std::abs(weight_on(character, v, swapped(node)) -
                                     weight_on(character, best, node));
      asymmetric += difference > 0.05;
      if (difference > worst + 1e-9)
        worst = difference, worst_vertex = static_cast<std::uint32_t>(v);
    }
    ASSERT_GT(mirrored, 150u);
    ASSERT_LT(mirrored, 400u);
    EXPECT_DOUBLE_EQ(weights.mirrored_share, static_cast<double>(mirrored) / 441.0);
    EXPECT_EQ(weights.asymmetric, asymmetric);
    EXPECT_NEAR(weights.worst_asymmetry, worst, 1e-6);
    EXPECT_EQ(weights.worst_asymmetric_vertex, worst_vertex);
    std::size_t tiny = 0;
    for (const Influences& w : character.influences)
      for (const float each : w.weight) tiny += each > 0.0f && each < 0.01f;
    EXPECT_EQ(weights.tiny, tiny);
    EXPECT_GT(tiny, 20u);
  }
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
