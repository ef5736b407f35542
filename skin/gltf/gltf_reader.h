#pragma once
#include <filesystem>

#include "skin/character/character.h"
#include "skin/gltf/gltf_document.h"

namespace backbend::skin {

/// A file without triangles: a skeleton alone, which read_skeleton() takes.
struct NoMeshError : CharacterError {
  using CharacterError::CharacterError;
};

/// Reads a skinned character from glTF 2.0 (.glb or .gltf, told apart by content).
///
/// All skins and meshes of the scene become one Character; units and axes stay the file's own.
/// Everything tolerated is in Character::warnings, by code: weights_renormalised,
/// weights_negative, influences_cut, joint_repeated, vertices_unweighted, rest_is_bind_pose,
/// bind_pose_unusable, skeleton_hint_wrong, skin_without_weights, morphs_applied, not_triangles,
/// no_positions, normals_computed, image_missing.
///
/// Throws CharacterError, one line `file: /json/path: cause`, for a file that is missing, not glTF
/// 2.0, broken, or without a skinned mesh. Reads nothing outside the file's folder.
/// Source: glTF 2.0 specification, sections 3.6 and 3.7.
Character read_character(const std::filesystem::path& file);
Character read_character(const GltfDocument& document);

/// The same for a file that may hold a skeleton alone (BVH, an early rig): without a skinned mesh
/// every node is a joint and all vertex arrays are empty. Throws CharacterError also for fewer than
/// two nodes.
Character read_skeleton(const GltfDocument& document);

}  // namespace backbend::skin
