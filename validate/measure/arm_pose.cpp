#include "validate/measure/arm_pose.h"

#include "skin/character/matrix_facts.h"

namespace backbend::validate {

PosedCharacter pose_with_arms(const Stage& stage, const solver::SpineSystem& system,
                              const solver::SpinePose& spine, const solver::RigidMotion& arms) {
  const skin::Character& character = stage.character();
  PosedCharacter posed;
  posed.spine = spine;
  posed.world_from_node = stage.driver().drive(system, spine);
  const glm::dmat4 carried = skin::rigid_matrix(arms.turn, arms.rest_origin, arms.posed_origin);
  std::vector<char> on_arm(character.nodes.size(), 0);
  for (const auto* arm : {&stage.anatomy().left_arm, &stage.anatomy().right_arm})
    if (!arm->empty()) on_arm[static_cast<std::size_t>(arm->front())] = 1;
  for (std::size_t n = 0; n < on_arm.size(); ++n) {  // parents stand before their children
    const int parent = character.nodes[n].parent;
    if (parent >= 0 && on_arm[static_cast<std::size_t>(parent)]) on_arm[n] = 1;
    if (on_arm[n]) posed.world_from_node[n] = carried * character.nodes[n].world_from_node;
  }
  posed.mesh = skin::skin(character, posed.world_from_node);
  return posed;
}

}  // namespace backbend::validate
