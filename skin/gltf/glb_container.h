#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace backbend::skin {

// Numbers of the binary form: of the file, and of its two kinds of chunks.
inline constexpr std::uint32_t kGlbMagic = 0x46546C67;  // "glTF"
inline constexpr std::uint32_t kChunkJson = 0x4E4F534A;
inline constexpr std::uint32_t kChunkBin = 0x004E4942;

/// What a .glb or .gltf file holds: the JSON text, and the binary chunk of a .glb.
struct GltfContainer {
  std::string json_text;
  std::optional<std::vector<std::uint8_t>> binary;
};

inline constexpr const char* kDracoExtension = "KHR_draco_mesh_compression";
inline constexpr const char* kMeshoptExtension = "EXT_meshopt_compression";

/// The JSON text of a .glb, without reading what comes after it; empty for what is not a whole one
/// or nests too deep, of which its reader complains. Waits for no pipe.
std::string peek_glb_json(const std::filesystem::path& file);

/// Splits a GLB into its chunks; bytes that do not start as a GLB are JSON text as they stand.
/// Refuses text whose brackets nest deeper than any real file's, before a parser sees it. Throws
/// CharacterError headed by `file`. Source: glTF 2.0 specification, chapter 4.
GltfContainer open_gltf_container(const std::string& file, const std::vector<std::uint8_t>& bytes);

}  // namespace backbend::skin
