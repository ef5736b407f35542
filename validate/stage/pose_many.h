#pragma once
#include <span>
#include <vector>

#include "skin/deform/skinning_plan.h"
#include "validate/stage/stage.h"

namespace backbend::validate {

/// Where the bodies of many poses go: memory of the caller's, pose after pose.
struct ManyPoses {
  std::span<glm::vec3> position;          // [poses x vertices] world space
  std::span<glm::vec3> normal;            // [poses x vertices] unit length
  std::span<glm::dmat4> world_from_node;  // [poses x nodes]
};

/// Skins a character, of which `plan` is made, by matrices of its nodes, pose after pose: the
/// results of skin::skin() for each. Throws Interrupted.
void skin_many(const skin::SkinningPlan& plan, std::size_t nodes,
               std::span<const glm::dmat4> world_from_node, std::span<glm::vec3> position,
               std::span<glm::vec3> normal);

/// The bodies for control values of a system on that character (radians, lengths), channel after
/// channel of pose after pose: what Stage::pose() gives for each alone, a studio's own rig and its
/// points included. Does not depend on the number of threads. Throws Interrupted; RigUnavailable.
void pose_many(const Stage& stage, const solver::SpineSystem& system,
               std::span<const double> controls, const ManyPoses& out);

}  // namespace backbend::validate
