#pragma once
#include <vector>

#include "skin/character/character.h"

namespace backbend::skin {

/// Of each part of the mesh, the node that alone moves it, if that node moves such parts only; else
/// -1. A node has a part for each material of its mesh.
std::vector<int> part_owners(const Character& character);

/// Of each node, whether it owns parts and no joint hangs from it: a prop, such as a gun in a hand.
/// None where the nodes that own parts have half of the vertices or more, unless the other joints
/// that move vertices are enough for a body and fewer than half of them own parts: the whole body
/// is of rigid parts.
std::vector<bool> nodes_of_props(const Character& character);

}  // namespace backbend::skin
