#pragma once
#include <string>
#include <vector>

#include "skin/character/character.h"

namespace tinygltf {
class Model;
}

namespace backbend::skin {

/// Every node of the file, parents before children (each tree depth first, in the file's order),
/// and where each file node went. World matrices are those of the node transforms.
struct GltfNodes {
  std::vector<Node> nodes;
  std::vector<int> index_of_file_node;
};

/// Throws CharacterError for a child that does not exist, a node with two parents, a cycle, or a
/// transform that is not finite. Never recurses: depth costs memory, not stack.
GltfNodes read_nodes(const tinygltf::Model& model, const std::string& file);

}  // namespace backbend::skin
