#pragma once
#include "skin/character/character.h"

namespace backbend::skin {

/// Whether a node is `above` or hangs from it, at any depth. False where either is -1.
bool is_ancestor(const Character& character, int above, int below);

}  // namespace backbend::skin
