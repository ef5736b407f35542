#pragma once
#include <string>
#include <vector>

#include "skin/gltf/gltf_document.h"
#include "tests/fuzz/target.h"

namespace backbend::fuzz {

/// The bytes as a glTF file, read as a character, skinned at rest, its spine found and posed, and
/// written down as `inspect` does; then as a clip. False where anything of it is refused.
bool use_gltf(const Bytes& gltf);

/// Characters as our own writers make them, with a motion: the strip of two joints and a figure of
/// sticks with a spine that is found.
std::vector<Bytes> glb_seeds();

/// A GLB of this JSON text and binary chunk, its lengths right.
Bytes glb_of(std::string json_text, Bytes binary);

/// Words of glTF's JSON.
std::vector<std::string> gltf_words();

}  // namespace backbend::fuzz
