#pragma once
#include <cstdint>
#include <vector>

struct aiScene;

namespace backbend::import {

/// What Assimp read, as binary glTF 2.0: nodes, skinned meshes, materials and every animation, keys
/// at their own times. FBX comes out +Y up in metres, from whatever axes and unit the file names;
/// Collada is converted by Assimp; BVH names neither and stays as it is.
///
/// Meshes are triangles; points and lines are left out. Corners that are equal in everything are
/// one vertex again. Weights stay as the file has them. Pictures outside the file are named by
/// their last path component. Throws skin::CharacterError for numbers that are not finite and for
/// indices out of range.
std::vector<std::uint8_t> encode_scene(const aiScene& scene);

}  // namespace backbend::import
