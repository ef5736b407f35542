#pragma once
#include <vector>

#include "skin/character/character.h"

namespace backbend::skin {

/// Of each part of the mesh, the node that alone moves it and moves nothing else: a prop's, or a
/// rigid limb's. -1 where there is none.
std::vector<int> part_owners(const Character& character);

/// Of each node, whether it moves parts that nothing else moves (one for each material), nothing
/// but these, and no joint hangs from it: a prop's (a gun in a hand). None where such parts have
/// half of the vertices or more: the body is of rigid parts.
std::vector<bool> nodes_of_props(const Character& character);

}  // namespace backbend::skin
