#pragma once
#include <glm/mat4x4.hpp>
#include <vector>

#include "skin/character/character.h"

namespace backbend::skin {

/// Of each node of a character at rest: the world from its frame.
inline std::vector<glm::dmat4> rest_matrices(const Character& character) {
  std::vector<glm::dmat4> out;
  out.reserve(character.nodes.size());
  for (const Node& node : character.nodes) out.push_back(node.world_from_node);
  return out;
}

}  // namespace backbend::skin
