#include "validate/stage/equal_shares.h"

#include <gtest/gtest.h>

#include <glm/gtc/matrix_transform.hpp>

#include "validate/calibrate/calibration_body.h"
#include "validate/metrics/chain/chain.h"

namespace backbend::validate {
namespace {

/// What a studio's own rig answers where the first joint above the hips does all of the bending.
solver::SpinePose bent_at_one_joint(const Stage& stage, const glm::dquat& hips,
                                    const glm::dquat& bend) {
  solver::SpinePose pose;
  const skin::Anatomy& anatomy = stage.anatomy();
  const std::vector<skin::Node>& nodes = stage.character().nodes;
  const auto node_of = [&](std::size_t k) -> const skin::Node& {
    return nodes[static_cast<std::size_t>(anatomy.spine[k])];
  };
  const auto about = [](const glm::dvec3& at, const glm::dquat& turn) {
    return glm::translate(glm::dmat4(1.0), at) * glm::mat4_cast(turn) *
           glm::translate(glm::dmat4(1.0), -at);
  };
  const glm::dmat4 moved = about(glm::dvec3(node_of(0).world_from_node[3]), hips);
  const glm::dmat4 bent = about(glm::dvec3(moved * node_of(1).world_from_node[3]), bend) * moved;
  auto body = std::make_shared<solver::WholeBody>();
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    bool above = false;
    for (int m = static_cast<int>(n); m >= 0; m = nodes[static_cast<std::size_t>(m)].parent)
      above = above || m == anatomy.spine[1];
    body->world_from_node.push_back((above ? bent : moved) * nodes[n].world_from_node);
  }
  pose.position.resize(anatomy.chest_index + 1);
  pose.turn.resize(anatomy.chest_index + 1);
  for (std::size_t k = 0; k <= anatomy.chest_index; ++k) {
    pose.position[k] =
        glm::dvec3(body->world_from_node[static_cast<std::size_t>(anatomy.spine[k])][3]);
    pose.turn[k] = k == 0 ? hips : bend * hips;
  }
  pose.hip.turn = hips;
  pose.hip.posed_origin = pose.position.front();
  pose.chest.turn = pose.turn.back();
  pose.chest.posed_origin = pose.position.back();
  pose.body = std::move(body);
  return pose;
}

TEST(EqualShares, TurnEachJointAlikeBetweenTheSameHipsAndChest) {
  const auto skin = tube_body(6);
  const Stage& stage = skin->stage();
  const std::size_t joints = stage.anatomy().chest_index;
  ASSERT_GE(joints, 3U);
  const glm::dquat hips = glm::angleAxis(0.3, glm::normalize(glm::dvec3(1, 2, 0)));
  const glm::dquat bend = glm::angleAxis(1.2, glm::normalize(glm::dvec3(1, 0, 0.4)));
  const solver::SpinePose pose = bent_at_one_joint(stage, hips, bend);
  const auto shared = with_equal_shares(stage, pose);
  ASSERT_TRUE(shared.has_value());
  EXPECT_LT(angle_between(shared->chest.turn, pose.chest.turn), 1e-9);
  EXPECT_EQ(shared->hip.posed_origin, pose.hip.posed_origin);
  for (std::size_t k = 1; k <= joints; ++k) {
    EXPECT_NEAR(angle_between(shared->turn[k - 1], shared->turn[k]),
                1.2 / static_cast<double>(joints), 1e-9);
    const auto node = static_cast<std::size_t>(stage.anatomy().spine[k]);
    EXPECT_LT(
        glm::distance(glm::dvec3(shared->body->world_from_node[node][3]), shared->position[k]),
        1e-12);
    // No bone changes its length.
    EXPECT_NEAR(glm::distance(shared->position[k], shared->position[k - 1]),
                glm::distance(pose.position[k], pose.position[k - 1]), 1e-12);
  }
  // What hangs from the chest keeps its place against it.
  const std::vector<skin::Node>& nodes = stage.character().nodes;
  const auto chest = static_cast<std::size_t>(stage.anatomy().spine[joints]);
  std::size_t hanging = 0;
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    if (nodes[n].parent != static_cast<int>(chest)) continue;
    ++hanging;
    const auto local = [&](const solver::SpinePose& each) {
      return glm::inverse(each.body->world_from_node[chest]) * each.body->world_from_node[n];
    };
    const glm::dmat4 apart = local(*shared) - local(pose);
    for (int c = 0; c < 4; ++c) EXPECT_LT(glm::length(apart[c]), 1e-9);
  }
  EXPECT_GT(hanging, 0U);
}

TEST(EqualShares, AreNotKnownOfAPoseWithoutItsBodyOrOfAChainThatIsNotTheSkeletons) {
  const auto skin = tube_body(6);
  solver::SpinePose pose =
      bent_at_one_joint(skin->stage(), {1, 0, 0, 0}, glm::angleAxis(0.5, glm::dvec3(1, 0, 0)));
  ASSERT_TRUE(with_equal_shares(skin->stage(), pose).has_value());
  solver::SpinePose longer = pose;
  longer.position.push_back(pose.position.back());
  EXPECT_FALSE(with_equal_shares(skin->stage(), longer).has_value());
  pose.body.reset();
  EXPECT_FALSE(with_equal_shares(skin->stage(), pose).has_value());
}

}  // namespace
}  // namespace backbend::validate
