#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "skin/character/character.h"

namespace tinygltf {
class Model;
}

namespace backbend::skin {

/// A parsed glTF 2.0 file with all its buffers in memory; nothing in it is checked beyond that.
struct GltfDocument {
  std::string file;  // as the user named it; the head of every error
  std::shared_ptr<const tinygltf::Model> model;
  std::vector<EncodedImage> images;  // one per glTF image; no bytes where it could not be had
  std::vector<Warning> warnings;
  std::uint64_t content_hash_low = 0, content_hash_high = 0;  // XXH3-128 of every byte read
};

/// Reads a .glb or .gltf and what it refers to inside its own folder. Throws CharacterError
/// (`file: /json/path: cause`) for anything that is not glTF 2.0, needs an extension that we do not
/// know, nests deeper than any real file, or lacks a buffer. A missing picture is a warning.
GltfDocument load_gltf(const std::filesystem::path& file);

/// Another program's file that was turned into glTF in memory: its name, its own bytes (which the
/// content hash is of), and the glTF. What that refers to is looked for beside `file`.
struct ConvertedFile {
  std::filesystem::path file;
  std::vector<std::uint8_t> source;
  std::vector<std::uint8_t> gltf;
};
GltfDocument load_gltf(const ConvertedFile& converted);

}  // namespace backbend::skin
