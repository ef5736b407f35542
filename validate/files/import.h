#pragma once
#include <filesystem>

#include "skin/gltf/gltf_document.h"

namespace backbend::validate {

/// Whether a file is of a format that another program reads for us: .fbx, .dae and .bvh, in
/// whatever case, by Assimp; a .glb whose meshes Draco compressed.
bool is_imported(const std::filesystem::path& file);

/// Such a file as plain glTF with everything in it: skeleton, skinned meshes, materials,
/// animations. FBX comes out +Y up in metres; the others keep what their files say.
///
/// Read by a process of its own (`backbend-import`), so that a crash, a hang or excessive memory
/// does not end this one. Throws skin::CharacterError, one line `file: cause`.
skin::GltfDocument import_document(const std::filesystem::path& file);

/// Any file that holds a skeleton: glTF as it is, the others through import_document(). Throws
/// skin::CharacterError.
skin::GltfDocument load_document(const std::filesystem::path& file);

}  // namespace backbend::validate
