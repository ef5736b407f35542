#pragma once
#include <vector>

#include "skin/weights/skin_places.h"

namespace backbend::skin {

/// Of each part of the mesh, its owner (skin/character/part_owners.h) where that is off the spine
/// and has no joint with weight right below it: the part is a prop, or one material of it. Else -1.
std::vector<int> prop_parts(const Character& character, const SkinPlaces& places);

}  // namespace backbend::skin
