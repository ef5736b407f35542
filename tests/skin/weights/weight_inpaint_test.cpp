#include "skin/weights/weight_inpaint.h"

#include <gtest/gtest.h>

#include <cmath>

#include "skin/weights/weight_graph.h"

namespace backbend::skin {
namespace {

using Index = std::size_t;

constexpr int kSide = 9;  // vertices of the sheet's side

/// A flat sheet of kSide x kSide vertices one apart, all on joint 0.
Character sheet() {
  Character out;
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) {
      out.bind_position.emplace_back(x, y, 0.0f);
      out.place.push_back(static_cast<std::uint32_t>(out.place.size()));
      Influences one;
      one.weight[0] = 1.0f;
      out.influences.push_back(one);
    }
  out.place_count = kSide * kSide;
  for (int y = 0; y + 1 < kSide; ++y)
    for (int x = 0; x + 1 < kSide; ++x) {
      const auto a = static_cast<std::uint32_t>(y * kSide + x);
      out.triangles.emplace_back(a, a + 1, a + kSide);
      out.triangles.emplace_back(a + 1, a + kSide + 1, a + kSide);
    }
  return out;
}

WeightGraph graph_of(const Character& character) {
  return weight_graph(character, character.bind_position);
}

std::uint32_t at(int x, int y) { return static_cast<std::uint32_t>(y * kSide + x); }

/// Joint 1 rises evenly from 0 at the left edge to 1 at the right.
std::vector<JointShares> ramp() {
  std::vector<JointShares> out;
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) {
      const double share = static_cast<double>(x) / (kSide - 1);
      out.push_back({{0, 1.0 - share}, {1, share}});
    }
  return out;
}

std::vector<InpaintNode> hole(const std::vector<JointShares>& kept = {}, double confidence = 0.0) {
  std::vector<InpaintNode> out;
  for (int y = 3; y < 6; ++y)
    for (int x = 3; x < 6; ++x)
      out.push_back({at(x, y), kept.empty() ? JointShares{} : kept[at(x, y)], confidence});
  return out;
}

// Both Laplacians of a linear field are 0 on a flat sheet, so it is the one minimum: what is left
// are rounding and the tiny pull that keeps lonely islands solvable.
TEST(InpaintWeights, FillsAHoleInAnEvenRampWithTheRamp) {
  const WeightGraph graph = graph_of(sheet());
  std::vector<JointShares> weights = ramp();
  const auto nodes = hole();
  for (const InpaintNode& each : nodes) weights[each.node] = {{0, 1.0}};  // must not be looked at
  const auto filled = inpaint_weights(graph, weights, nodes);
  for (Index i = 0; i < nodes.size(); ++i) {
    ASSERT_EQ(filled[i].size(), 2u);
    EXPECT_NEAR(filled[i].at(1), ramp()[nodes[i].node].at(1), 1e-6) << nodes[i].node;
  }
}

TEST(InpaintWeights, KeepsWhatIsSureAndLeavesWhatIsNot) {
  const WeightGraph graph = graph_of(sheet());
  const std::vector<JointShares> known(graph.node_count(), JointShares{{0, 1.0}});
  const auto middle = [&](double confidence) {
    return inpaint_weights(graph, ramp(), hole(known, confidence))[4].at(0);
  };
  EXPECT_GT(middle(1.0), 0.995);
  EXPECT_NEAR(middle(0.0), 0.5, 1e-6);
  EXPECT_GT(middle(0.01), 0.51);
  EXPECT_LT(middle(0.01), middle(0.1));
}

// A smooth fill of a step overshoots on both sides; weights may not.
TEST(InpaintWeights, HasNoNegativeWeightAndSumsToOne) {
  const WeightGraph graph = graph_of(sheet());
  std::vector<JointShares> weights;
  for (int i = 0; i < kSide * kSide; ++i)
    weights.push_back(i % kSide < 3 ? JointShares{{0, 1.0}} : JointShares{{1, 1.0}});
  for (const JointShares& shares : inpaint_weights(graph, weights, hole())) {
    double sum = 0.0;
    for (const auto& [joint, share] : shares) {
      EXPECT_GT(share, 0.0);
      sum += share;
    }
    EXPECT_NEAR(sum, 1.0, 1e-12);
  }
}

TEST(InpaintWeights, SaysNothingOfAnIslandThatNothingReaches) {
  const WeightGraph graph = graph_of(sheet());
  std::vector<InpaintNode> all;
  for (std::uint32_t n = 0; n < graph.node_count(); ++n) all.push_back({n, {}, 0.0});
  for (const JointShares& shares : inpaint_weights(graph, ramp(), all)) EXPECT_TRUE(shares.empty());
}

TEST(InpaintWeights, DoesNotDependOnTheUnit) {
  Character large = sheet();
  for (glm::vec3& p : large.bind_position) p *= 1000.0f;
  std::vector<JointShares> weights = ramp();
  weights[at(4, 2)] = {{0, 1.0}};  // a bump, so that the fill is not the ramp
  const auto small_fill = inpaint_weights(graph_of(sheet()), weights, hole());
  const auto large_fill = inpaint_weights(graph_of(large), weights, hole());
  ASSERT_GT(std::abs(small_fill[1].at(0) - ramp()[at(4, 3)].at(0)), 0.01);
  for (Index i = 0; i < small_fill.size(); ++i)
    EXPECT_NEAR(small_fill[i].at(0), large_fill[i].at(0), 1e-9);
}

TEST(WeightGraph, JoinsSplitVerticesAndNotPartsThatOnlyTouch) {
  Character two = sheet();
  const auto add_copy = [&](std::uint32_t of, const Influences& influences) {
    two.bind_position.push_back(two.bind_position[of]);
    two.place.push_back(two.place[of]);
    two.influences.push_back(influences);
  };
  Influences other;
  other.joint[0] = 1;
  other.weight[0] = 1.0f;
  add_copy(at(2, 2), two.influences[at(2, 2)]);
  add_copy(at(3, 3), other);
  const WeightGraph graph = graph_of(two);
  EXPECT_EQ(graph.node[two.vertex_count() - 2], graph.node[at(2, 2)]);
  EXPECT_NE(graph.node[two.vertex_count() - 1], graph.node[at(3, 3)]);
  EXPECT_EQ(graph.node_count(), static_cast<Index>(kSide * kSide + 1));
}

TEST(InfluencesOf, KeepsTheLargestWithoutCrumbsAndSumsToOne) {
  const Influences out = influences_of({{0, 0.3}, {1, 0.0005}, {2, 0.4}, {3, 0.1}, {4, 0.1995}}, 3);
  EXPECT_EQ(out.joint[0], 2);
  EXPECT_EQ(out.joint[1], 0);
  EXPECT_EQ(out.joint[2], 4);
  EXPECT_EQ(out.weight[3], 0.0f);
  EXPECT_NEAR(out.weight[0] + out.weight[1] + out.weight[2], 1.0f, 1e-6f);
  EXPECT_NEAR(share_moved({{0, 1.0}}, {{0, 0.25}, {1, 0.75}}), 0.75, 1e-12);
}

}  // namespace
}  // namespace backbend::skin
