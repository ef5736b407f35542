#pragma once
#include <vector>

#include "skin/weights/skin_places.h"

namespace backbend::skin {

/// Of each part of the mesh, whether it is a prop: moved by one joint off the spine that moves
/// nothing else and has no joint with weight right below it.
std::vector<bool> prop_parts(const Character& character, const SkinPlaces& places);

}  // namespace backbend::skin
