#pragma once
#include "skin/character/character.h"

namespace backbend::skin {

/// Gives vertices of a part that came without a normal (zero length) one: the area-weighted mean of
/// the faces around their place, unit length; +Y where those cancel out. `mirrored`: the way from
/// bind space to the world turns faces over, and the triangles wind outwards in the world.
/// Returns whether any vertex lacked a normal.
bool fill_missing_normals(Character& character, const Part& part, bool mirrored);

}  // namespace backbend::skin
