#pragma once
#include <cstdint>
#include <vector>

namespace backbend::import {

/// A binary glTF whose meshes Draco compressed (KHR_draco_mesh_compression), with their vertices
/// and triangles as plain accessors and everything else as it was. Vertices keep the order that the
/// compression gave them; values are as it rounded them.
///
/// Throws skin::CharacterError for what is not such a file, holds its buffers elsewhere, or says
/// something else of a mesh than its compressed data do; nlohmann::json::exception for JSON that is
/// not glTF. Source: the extension's text in Khronos' registry.
std::vector<std::uint8_t> decompress_draco(const std::vector<std::uint8_t>& glb);

}  // namespace backbend::import
