#pragma once
#include <cstdint>
#include <vector>

#include "cli/import/fbx_geometry.h"
#include "skin/character/character.h"

struct aiScene;

namespace backbend::import {

/// Two joints that move one mesh have one name: Assimp gives the second the first one's bind
/// matrix.
class RepeatedJointName : public skin::CharacterError {
 public:
  using skin::CharacterError::CharacterError;
};

/// What Assimp read, as binary glTF 2.0: nodes, skinned meshes, materials and every animation, keys
/// at their own times. FBX comes out +Y up in metres, from whatever axes and unit the file names;
/// Collada is converted by Assimp; BVH names neither and stays as it is.
///
/// Meshes are triangles; points and lines are left out. Corners that are equal in everything are
/// one vertex again. Weights stay as the file has them. Pictures outside the file are named by
/// their last path component. Throws RepeatedJointName, and skin::CharacterError for numbers that
/// are not finite and for indices out of range.
///
/// `geometric`: what moves the meshes of a node, before their joints do, and not the node itself.
std::vector<std::uint8_t> encode_scene(const aiScene& scene, const GeometricTransforms& geometric);

}  // namespace backbend::import
