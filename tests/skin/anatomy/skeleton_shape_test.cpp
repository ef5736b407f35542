// What a skeleton looks like, against plain counts over random trees; pairs and scene roots on both
// sides of what decides them.
#include "skin/anatomy/skeleton_shape.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_inverse.hpp>
#include <random>

#include "skin/anatomy/anatomy.h"
#include "skin/anatomy/spine_finder.h"
#include "skin/character/ancestor.h"
#include "tests/skin/stick_figure.h"

namespace backbend::skin {
namespace {

std::size_t z(int i) { return static_cast<std::size_t>(i); }

/// Two trees of nodes anywhere, two thirds of them joints, vertices with up to four of those.
Character tangle(unsigned seed) {
  std::mt19937 rng(seed);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  Character c;
  c.file_name = "tangle.glb";
  for (int n = 0; n < 40; ++n)
    add_node(c, "node" + std::to_string(n), n == 0 || n == 17 ? -1 : static_cast<int>(rng() % z(n)),
             {unit(rng), 2.0 * unit(rng), unit(rng) - 0.5});
  for (int n = 0; n < 40; ++n)
    if (n % 3 != 1) c.joints.push_back({n, glm::affineInverse(c.nodes[z(n)].world_from_node)});
  for (int v = 0; v < 100; ++v) {
    c.bind_position.emplace_back(unit(rng), 3.0 * unit(rng), unit(rng));
    c.bind_normal.emplace_back(0, 0, 1);
    Influences w;
    const float share[] = {0.4f, 0.3f, 0.2f, 0.1f};
    const std::size_t count = 1 + rng() % 4;
    float left = 1.0f;
    for (std::size_t k = 0; k < count; ++k) {
      w.joint[k] = static_cast<std::uint16_t>((v * 7 + static_cast<int>(k) * 5) % 26);
      w.weight[k] = share[k];
      left -= share[k];
    }
    w.weight[0] += left;
    c.influences.push_back(w);
  }
  return c;
}

TEST(SkeletonShape, PassesOverNodesThatOnlyUndoAScale) {
  // As Maya's exporter writes them: between each joint and the one that it hangs from, a node that
  // stands where the joint does and is none.
  const Character plain = stick_figure();
  Character c = plain;
  const int count = static_cast<int>(c.nodes.size());
  for (int n = 0; n < count; ++n) {
    const int parent = c.nodes[z(n)].parent;
    if (parent < 0 || c.nodes[z(parent)].name == "scene") continue;
    const glm::dvec3 at(c.nodes[z(n)].world_from_node[3]);
    c.nodes[z(n)].parent = add_node(c, c.nodes[z(n)].name + "_scaleCompensation", parent, at);
  }
  const SkeletonShape shape = measure_skeleton(c), known = measure_skeleton(plain);
  ASSERT_EQ(shape.pairs.size(), known.pairs.size());
  for (std::size_t i = 0; i < shape.pairs.size(); ++i) {
    EXPECT_EQ(shape.pairs[i].left, known.pairs[i].left);
    EXPECT_EQ(shape.pairs[i].right, known.pairs[i].right);
    EXPECT_EQ(shape.pairs[i].parent, known.pairs[i].parent);
  }
  EXPECT_EQ(find_anatomy(c).left_arm, find_anatomy(plain).left_arm);
  EXPECT_EQ(find_anatomy(c).spine, find_anatomy(plain).spine);
}

TEST(SkeletonShape, DoesNotCountVerticesThatCameWithoutWeights) {
  // The reader leaves them to the first joint, which does not mean them.
  Character c = stick_figure();
  const std::size_t hips = z(stick_node(c, "hips"));
  const double before = measure_skeleton(c).weight[hips];
  stick_vertex(c, static_cast<int>(hips));
  EXPECT_GT(measure_skeleton(c).weight[hips], before);
  for (std::uint32_t k = 3; k > 0; --k)
    c.unweighted.push_back(static_cast<std::uint32_t>(c.vertex_count()) - k);
  EXPECT_EQ(measure_skeleton(c).weight[hips], before);
}

TEST(SkeletonShape, IsWhatCountingGives) {
  for (unsigned seed = 1; seed <= 4; ++seed) {
    const Character c = tangle(seed);
    const SkeletonShape shape = measure_skeleton(c);
    const int count = static_cast<int>(c.nodes.size());
    const auto above = [&](int a, int b) {
      for (int n = b; n >= 0; n = c.nodes[z(n)].parent)
        if (n == a) return true;
      return false;
    };
    glm::dvec3 low(1e9), high(-1e9);
    for (const glm::vec3& p : c.bind_position) {
      low = glm::min(low, glm::dvec3(p));
      high = glm::max(high, glm::dvec3(p));
    }
    EXPECT_LT(glm::distance(shape.low, low), 1e-6);
    EXPECT_LT(glm::distance(shape.high, high), 1e-6);
    EXPECT_NEAR(shape.size, high.y - low.y, 1e-6);
    for (int n = 0; n < count; ++n) {
      double own = 0.0, below = 0.0, reach = 0.0;
      for (std::size_t v = 0; v < c.vertex_count(); ++v)
        for (std::size_t k = 0; k < kMaxInfluences; ++k) {
          const int node = c.joints[c.influences[v].joint[k]].node;
          if (node == n) own += c.influences[v].weight[k];
          if (above(n, node)) below += c.influences[v].weight[k];
        }
      int farthest = n;
      for (int m = 0; m < count; ++m) {
        EXPECT_EQ(is_ancestor(c, n, m), above(n, m));
        std::vector<int> path;
        for (int k = m; above(n, m) && k >= 0; k = k == n ? -1 : c.nodes[z(k)].parent)
          path.insert(path.begin(), k);
        EXPECT_EQ(path_down(c, n, m), path);
        const double d =
            glm::distance(c.nodes[z(n)].world_from_node[3], c.nodes[z(m)].world_from_node[3]);
        if (m % 3 != 1 && above(n, m) && d > reach) reach = d, farthest = m;
      }
      EXPECT_NEAR(shape.weight[z(n)], own, 1e-5);
      EXPECT_NEAR(shape.weight_below[z(n)], below, 1e-5);
      EXPECT_EQ(shape.is_joint[z(n)], n % 3 != 1);
      EXPECT_NEAR(shape.reach[z(n)], reach, 1e-12);
      EXPECT_EQ(shape.farthest[z(n)], farthest);
      for (const int child : shape.children[z(n)]) EXPECT_EQ(c.nodes[z(child)].parent, n);
      EXPECT_EQ(shape.position[z(n)], glm::dvec3(c.nodes[z(n)].world_from_node[3]));
    }
    EXPECT_FALSE(is_ancestor(c, -1, 0));
    EXPECT_FALSE(is_ancestor(c, -1, -1));
  }
  Character none;
  none.file_name = "none.glb";
  add_node(none, "alone", -1, {0, 0, 0});
  EXPECT_THROW(measure_skeleton(none), CharacterError);
}

TEST(SkeletonShape, TakesAnEndMarkerThatMovesAVertexForAJoint) {
  for (const float weight : {0.9f, 1.0f, 2.5f}) {
    Character c = stick_figure();
    const int node = add_node(c, "hand_end", stick_node(c, "hand.L"), {0.8, 1.35, 0});
    c.joints.push_back({node, glm::affineInverse(c.nodes[z(node)].world_from_node)});
    for (float left = weight; left > 0.0f; left -= 1.0f) {
      Influences w = c.influences[0];
      w.joint[1] = static_cast<std::uint16_t>(c.joints.size() - 1);
      w.weight = {std::max(0.0f, 1.0f - left), std::min(1.0f, left)};
      if (left >= 1.0f) {
        std::swap(w.joint[0], w.joint[1]);
        std::swap(w.weight[0], w.weight[1]);
      }
      c.bind_position.push_back(c.bind_position[0]);
      c.bind_normal.push_back(c.bind_normal[0]);
      c.place.push_back(0);
      c.influences.push_back(w);
    }
    EXPECT_EQ(measure_skeleton(c).name[z(node)].end, weight < 1.0f) << weight;
  }
}

/// Vertices on every node, and two of the first that give the mesh a size of 2.
void clothe(Character& c) {
  for (int n = 0; n < static_cast<int>(c.nodes.size()); ++n) stick_vertex(c, n);
  Influences w;
  w.weight[0] = 1.0f;
  for (const double y : {-1.0, 1.0}) {
    c.bind_position.emplace_back(0, y, 0);
    c.bind_normal.emplace_back(0, 0, 1);
    c.influences.push_back(w);
  }
}

/// Two branches of one bone each below a joint, their ends where told, in a mesh of a size of 2.
SkeletonShape branches(const std::string& a, const glm::dvec3& end_a, const std::string& b,
                       const glm::dvec3& end_b) {
  Character c;
  const int root = add_node(c, "base", -1, {0, 0, 0});
  for (const auto& [name, end] : {std::pair(a, end_a), std::pair(b, end_b)}) {
    const int from = add_node(c, name, root, 0.1 * end);
    add_node(c, name + "_x", from, end);
  }
  clothe(c);
  return measure_skeleton(c);
}

TEST(SkeletonShape, FindsPairsByNamesOrByWhereTheyReach) {
  const glm::dvec3 left(0.5, 0.3, 0.2), right(-0.5, 0.3, 0.2);
  // By names, whatever they look like; the left one first.
  for (const bool swapped : {false, true}) {
    const SkeletonShape named = branches(swapped ? "thing_R" : "thing_L", left,
                                         swapped ? "thing_L" : "thing_R", {0, 0.9, 0});
    ASSERT_EQ(named.pairs.size(), 1u);
    EXPECT_TRUE(named.pairs[0].named);
    EXPECT_EQ(named.pairs[0].parent, 0);
    EXPECT_EQ(named.pairs[0].left, swapped ? 3 : 1);
    EXPECT_EQ(named.pairs[0].right, swapped ? 1 : 3);
  }
  EXPECT_TRUE(branches("thing_L", left, "other_R", right).pairs.empty());
  EXPECT_TRUE(branches("thing_L", left, "thing", right).pairs.empty());
  // Without sides: across one axis, as far, and of one kind.
  const SkeletonShape alike = branches("q1", left, "q2", right);
  ASSERT_EQ(alike.pairs.size(), 1u);
  EXPECT_FALSE(alike.pairs[0].named);
  EXPECT_EQ(alike.pairs[0].left, 1);
  EXPECT_EQ(alike.pairs[0].right, 3);
  EXPECT_TRUE(branches("jaw", left, "hand", right).pairs.empty());
  // 20 degrees from the axis is less than the cosine of 0.94 allows, 19 is not; across each axis.
  for (int axis = 0; axis < 3; ++axis)
    for (const double degrees : {19.0, 21.0}) {
      glm::dvec3 half(0.0), level(0.0);
      half[axis] = 0.4 * std::cos(glm::radians(degrees));
      half[(axis + 1) % 3] = 0.4 * std::sin(glm::radians(degrees));
      level[(axis + 2) % 3] = 0.6;
      EXPECT_EQ(branches("q1", level + half, "q2", level - half).pairs.size(),
                degrees < 20.0 ? 1u : 0u)
          << axis << " " << degrees;
    }
  // One reaches a tenth less than the other, or a little more than that.
  for (const double longer : {1.09, 1.13})
    for (const bool first : {false, true})
      EXPECT_EQ(branches("q1", (first ? longer : 1.0) * left, "q2", (first ? 1.0 : longer) * right)
                    .pairs.size(),
                longer < 1.11 ? 1u : 0u);
  // Their ends are a fiftieth of the size apart, and no less.
  for (const double apart : {0.0385, 0.0425})
    EXPECT_EQ(branches("q1", {0.5 * apart, 0.6, 0}, "q2", {-0.5 * apart, 0.6, 0}).pairs.size(),
              apart > 0.0405 ? 1u : 0u)
        << apart;
}

/// The limbs of a body of size 2 with one pair of two-bone branches, `reach` long, on its spine's
/// middle; its neck and head above.
std::vector<LimbPair> limbs_with(const std::string& left, const std::string& right, double reach) {
  Character c;
  const int base = add_node(c, "base", -1, {0, 0, 0});
  const int middle = add_node(c, "middle", base, {0, 0.5, 0});
  const int head = add_node(c, "head", add_node(c, "neck", middle, {0, 0.8, 0}), {0, 0.9, 0});
  for (const auto& [name, side] : {std::pair(left, 1.0), std::pair(right, -1.0)}) {
    const int from = add_node(c, name, middle, {0.1 * side, 0.5, 0});
    add_node(c, "end_" + std::to_string(c.nodes.size()), from, {(0.1 + reach) * side, 0.5, 0});
    c.nodes.back().name = side > 0.0 ? "bit_L" : "bit_R";
  }
  clothe(c);
  return find_limbs(c, measure_skeleton(c), head);
}

TEST(FindLimbs, TakesPairsThatReachFarOrAreCalledSo) {
  // 0.12 of the size where no name helps, 0.02 where one does.
  EXPECT_TRUE(limbs_with("q_L", "q_R", 0.235).empty());
  EXPECT_EQ(limbs_with("q_L", "q_R", 0.245).size(), 1u);
  EXPECT_TRUE(limbs_with("q1", "q2", 0.235).empty());
  EXPECT_EQ(limbs_with("q1", "q2", 0.245).size(), 1u);
  EXPECT_TRUE(limbs_with("arm_L", "arm_R", 0.038).empty());
  EXPECT_EQ(limbs_with("arm_L", "arm_R", 0.042).size(), 1u);
  for (const char* other : {"breast", "ear", "index_finger", "arm_ctrl"})
    EXPECT_TRUE(limbs_with(std::string(other) + "_L", std::string(other) + "_R", 0.9).empty())
        << other;
  const struct {
    const char* name;
    LimbPair::Kind kind;
  } kinds[] = {{"leg", LimbPair::Kind::leg},      {"front_leg", LimbPair::Kind::arm},
               {"hind_leg", LimbPair::Kind::leg}, {"arm", LimbPair::Kind::arm},
               {"clavicle", LimbPair::Kind::arm}, {"hind_arm", LimbPair::Kind::leg},
               {"fin", LimbPair::Kind::unknown},  {"front_fin", LimbPair::Kind::arm},
               {"rear_fin", LimbPair::Kind::leg}, {"q", LimbPair::Kind::unknown}};
  for (const auto& each : kinds) {
    const auto limbs =
        limbs_with(std::string(each.name) + "_L", std::string(each.name) + "_R", 0.5);
    ASSERT_EQ(limbs.size(), 1u) << each.name;
    EXPECT_EQ(limbs[0].kind, each.kind) << each.name;
    EXPECT_EQ(limbs[0].pair.left, 4);
    EXPECT_EQ(limbs[0].pair.right, 6);
  }
}

TEST(SceneRoot, MovesNothingAndStandsAtTheOriginOrOutside) {
  Character c = stick_figure();
  const SkeletonShape before = measure_skeleton(c);
  const double size = before.size;
  const struct {
    glm::dvec3 at;
    bool root;
  } cases[] = {{{0, 0, 0}, true},
               {{0.009 * size, 0, 0}, true},
               {{0.02, 0.5, 0.0}, false},
               {before.low - 0.015 * size, false},
               {before.low - 0.025 * size, true},
               {before.high + 0.015 * size, false},
               {before.high + 0.025 * size, true},
               {{0.03, before.high.y + 0.025 * size, 0.0}, true},
               {{before.low.x - 0.025 * size, 0.5, 0.0}, true}};
  for (const auto& each : cases) {
    const int node = add_node(c, "extra", -1, each.at);
    EXPECT_EQ(is_scene_root(measure_skeleton(c), node), each.root) << each.at.x << " " << each.at.y;
    c.nodes.pop_back();
  }
  // What moves the least of a vertex is of the body.
  const int node = add_node(c, "extra", -1, {0, 0, 0});
  c.joints.push_back({node, glm::dmat4(1.0)});
  c.influences[0].joint[1] = static_cast<std::uint16_t>(c.joints.size() - 1);
  c.influences[0].weight = {0.75f, 0.25f};
  EXPECT_FALSE(is_scene_root(measure_skeleton(c), node));
}

}  // namespace
}  // namespace backbend::skin
