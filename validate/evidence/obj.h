#pragma once
#include <string>

#include "skin/character/character.h"

namespace backbend::validate {

/// A posed mesh as Wavefront OBJ: positions, normals, triangles; world space, nine digits.
std::string obj_text(const skin::Character& character, const skin::PosedMesh& mesh);

}  // namespace backbend::validate
