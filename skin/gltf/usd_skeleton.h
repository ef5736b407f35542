#pragma once
#include <glm/mat4x4.hpp>
#include <string>
#include <vector>

#include "skin/gltf/glb_writer_skeleton.h"

namespace backbend::skin {

/// parent_from_node of its parts.
glm::dmat4 matrix_of(const NodeTransform& t);

/// A skeleton as UsdSkel holds it; parents stand before their children, and one root above all. One
/// entry per joint: the nodes that move vertices and those above them, in the character's order,
/// then what the skin needs besides.
struct UsdSkeleton {
  std::vector<std::string> path;                   // `hips/spine_01`, identifiers, all unique
  std::vector<std::string> name;                   // of the node, made unique
  std::vector<glm::dmat4> bind;                    // skeleton_from_joint at bind
  std::vector<NodeTransform> rest;                 // parent_from_joint
  std::vector<std::vector<NodeTransform>> frames;  // [frame][joint], parent_from_joint
  std::vector<std::size_t> of_skin;                // [joint of the character], and the still one
  glm::dmat4 geom_bind{1.0};                       // skeleton_from_mesh at bind
};

/// Skinned points are sum of weight * skeleton_from_joint * bind^-1 * geom_bind * point: of the
/// many ways to split an inverse bind matrix in two, the one whose bind pose is the rest pose where
/// the file's is. With `unskinned` the last entry of `of_skin` is a joint that never moves. Throws
/// CharacterError.
UsdSkeleton usd_skeleton(const Character& character, const GlbAnimation& animation, bool unskinned);

}  // namespace backbend::skin
