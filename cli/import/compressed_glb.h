#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "skin/gltf/glb_writer_document.h"

namespace backbend::import {

/// A binary glTF that is decompressed in place: its JSON, and the chunk that all its data are in.
struct CompressedGlb {
  skin::GlbDocument document;  // begins with the chunk, where plain accessors expect it
  std::vector<std::uint8_t> binary;

  /// Throws skin::CharacterError where the file's own chunk is not its first buffer.
  explicit CompressedGlb(const std::vector<std::uint8_t>& glb);

  /// The bytes of a compressed run that `place` (buffer, byteOffset, byteLength) names. Throws
  /// skin::CharacterError beyond the chunk's end.
  struct Run {
    const std::uint8_t* data = nullptr;
    std::size_t size = 0;
  };
  Run run_of(const skin::Json& place) const;

  /// The file without the need for `extension`.
  std::vector<std::uint8_t> finish(const std::string& extension);
};

}  // namespace backbend::import
