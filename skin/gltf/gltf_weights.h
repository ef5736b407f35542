#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "skin/character/character.h"
#include "skin/character/weight_source.h"
#include "skin/gltf/gltf_document.h"

namespace backbend::skin {

/// A character and where its file stores the weights.
struct WeightedGltf {
  Character character;
  std::vector<WeightSource> sources;   // by first_vertex; parts that hang on a node have none
  std::vector<std::uint32_t> off_sum;  // vertices whose stored weights do not sum to 1, ascending
};

/// read_character() for those who will change the weights in the file.
WeightedGltf read_weighted(const GltfDocument& document);

/// The file `document.file` as a GLB with other weights at some vertices, and nothing else changed.
///
/// `influences` has one entry a vertex of the character, `changed` says which of them to write.
/// Component types stay; 8 and 16 bit weights are rounded so that they sum to exactly one. In a GLB
/// the bytes of those vertices are replaced in place. Where that cannot be (sparse accessors, a
/// joint number that the type cannot hold) an accessor gets new bytes at the end; a .gltf becomes a
/// GLB that holds its buffers and pictures. Every other accessor is compared with what it was.
///
/// Throws CharacterError: compressed meshes, weights that share bytes with something else, a joint
/// that is not in the vertex's skin, more joints than the vertex has places, a file that changed
/// since it was read.
std::vector<std::uint8_t> encode_with_weights(const GltfDocument& document,
                                              const WeightedGltf& from,
                                              std::span<const Influences> influences,
                                              const std::vector<bool>& changed);

}  // namespace backbend::skin
