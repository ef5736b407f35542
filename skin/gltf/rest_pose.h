#pragma once
#include <string>
#include <vector>

#include "skin/character/character.h"

namespace backbend::skin {

/// One skin of a file: which nodes are its joints and how the mesh stood to each at bind.
struct BoundSkin {
  std::vector<int> node;                    // into the character's nodes, one per joint
  std::vector<glm::dmat4> joint_from_mesh;  // inverse bind matrices
  glm::dmat4 world_from_mesh{1.0};          // at bind: place_at_bind() finds it
  int mesh_node = -1;                       // that the first mesh of this skin hangs on
};

/// The world place of the mesh at bind: where the skin's main root (the joint above most others)
/// puts it. A bind shape or dequantisation baked into every inverse bind matrix cancels out here.
/// Identity for a skin without an invertible joint.
glm::dmat4 place_at_bind(const std::vector<Node>& nodes, const BoundSkin& skin);

/// Decides which pose is the rest, and moves the nodes to it.
///
/// The nodes of a file often hold the first frame of some animation, and only the inverse binds
/// remember the pose in which the weights were painted. So the bind pose is the rest where the
/// inverse binds describe a skeleton (invertible, bones as long as the nodes' own, in the world or
/// in their parents' frames) and stand more than 1 % of the character's size from the node pose; a
/// warning `rest_is_bind_pose` says so.
/// Where they describe none, the node pose stays, with `bind_pose_unusable`. A root that leans in
/// that first frame would lean the whole bind pose: it is stood up, and `skins` with it, where the
/// nodes of all meshes say how they stood, along the axes of the world.
///
/// `vertex_skin` gives the skin of each vertex of `character`, -1 for rigid ones; influences index
/// Character::joints. Returns the warnings.
std::vector<Warning> settle_rest_pose(Character& character, std::vector<BoundSkin>& skins,
                                      const std::vector<int>& vertex_skin);

}  // namespace backbend::skin
