#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "skin/character/character.h"
#include "skin/character/weight_source.h"
#include "skin/gltf/rest_pose.h"

namespace tinygltf {
class Model;
}

namespace backbend::skin {

/// What the merged arrays of a Character do not say about where they came from.
struct GltfGeometry {
  std::vector<BoundSkin> skins;
  std::vector<int> vertex_skin;  // per vertex: its skin, -1 for parts that hang rigidly on a node
  std::vector<WeightSource> weight_sources;
  std::vector<std::uint32_t> off_sum;  // vertices whose stored weights do not sum to 1
};

/// Merges every mesh of the file's scene into `character`, whose nodes and materials stand already:
/// vertex, triangle, part and joint arrays, and warnings.
///
/// Skinned meshes ignore their own node's transform, others hang on it with weight 1. Morph targets
/// are applied with their default weights. Vertices without any weight keep weights of 0. Triangles
/// wind outwards in world space also where a mirroring transform turned them over.
/// `index_of_file_node` leads from file node numbers to character.nodes.
///
/// Throws CharacterError: an index out of range, a value that is not finite, or more vertices and
/// triangles than any real character has.
GltfGeometry read_geometry(const tinygltf::Model& model, const std::string& file,
                           const std::vector<int>& index_of_file_node, Character& character);

}  // namespace backbend::skin
