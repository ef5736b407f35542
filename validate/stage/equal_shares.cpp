#include "validate/stage/equal_shares.h"

#include <glm/gtc/matrix_inverse.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include "skin/character/matrix_facts.h"

namespace backbend::validate {

std::optional<solver::SpinePose> with_equal_shares(const Stage& stage,
                                                   const solver::SpinePose& pose) {
  using Index = std::size_t;
  const std::vector<skin::Node>& nodes = stage.character().nodes;
  const skin::Anatomy& anatomy = stage.anatomy();
  const Index joints = anatomy.chest_index;
  // Two joints in one place are one of the chain: of which joint of it each one is.
  const std::vector<double>& along = stage.driver().joint_fractions();
  std::vector<Index> of_chain(joints + 1, 0);
  for (Index k = 1; k <= joints; ++k)
    of_chain[k] = of_chain[k - 1] + (along[k] - along[k - 1] > 1e-6 ? 1 : 0);
  if (!pose.body || joints == 0 || pose.position.size() != of_chain.back() + 1) return std::nullopt;

  glm::dquat whole = glm::normalize(pose.chest.turn * glm::conjugate(pose.hip.turn));
  if (whole.w < 0.0) whole = -whole;
  const double angle = glm::angle(whole) / static_cast<double>(joints);
  const glm::dquat share =
      angle > 0.0 ? glm::angleAxis(angle, glm::axis(whole)) : glm::dquat(1, 0, 0, 0);

  solver::SpinePose out = pose;
  auto body = std::make_shared<solver::WholeBody>();
  body->world_from_node = pose.body->world_from_node;
  std::vector<glm::dmat4>& world = body->world_from_node;
  std::vector<int> place(nodes.size(), -1);  // along the spine, of the spine's joints
  for (Index k = 0; k <= joints; ++k)
    place[static_cast<Index>(anatomy.spine[k])] = static_cast<int>(k);
  glm::dquat turn = pose.hip.turn;
  std::vector<bool> moves(nodes.size(), false);
  for (Index n = 0; n < nodes.size(); ++n) {  // parents stand before their children
    const int parent = nodes[n].parent;
    if (place[n] == 0 || (place[n] < 0 && (parent < 0 || !moves[static_cast<Index>(parent)])))
      continue;
    moves[n] = true;
    if (place[n] < 0) {
      const auto p = static_cast<Index>(parent);
      world[n] =
          world[p] * glm::inverse(pose.body->world_from_node[p]) * pose.body->world_from_node[n];
      continue;
    }
    // Rigid from the joint below, from rest; then the share about the joint's own place.
    const auto k = static_cast<Index>(place[n]);
    const auto below = static_cast<Index>(anatomy.spine[k - 1]);
    const glm::dmat4 carried =
        world[below] * glm::inverse(nodes[below].world_from_node) * nodes[n].world_from_node;
    const glm::dvec3 at = skin::origin(carried);
    world[n] = glm::translate(glm::dmat4(1.0), at) * glm::mat4_cast(share) *
               glm::translate(glm::dmat4(1.0), -at) * carried;
    turn = share * turn;
    out.position[of_chain[k]] = at;
    out.turn[of_chain[k]] = turn;
  }
  out.chest.turn = out.turn.back();
  out.chest.posed_origin = out.position.back();
  out.arms = out.chest;
  out.body = std::move(body);
  return out;
}

}  // namespace backbend::validate
