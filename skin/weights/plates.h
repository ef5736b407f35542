#pragma once
#include "skin/anatomy/anatomy.h"
#include "skin/character/character.h"

namespace backbend::skin {

inline constexpr const char* kPlatesPart =
    "the body is built of plates, which part where they meet";

/// Whether a body is built of plates, as mannequins and robots are: pieces of the surface that no
/// vertices join and of which each has a joint of its own. Plates part where they meet, by design.
///
/// A piece has six vertices or more, those at one place with the same weights (within 1 %) counted
/// once. Of the joints that move most of a piece half move one alone, eight at least and a vertebra
/// of the torso among them: hands that are cut at every knuckle are not yet a body.
bool is_built_of_plates(const Character& character, const Anatomy& anatomy);

}  // namespace backbend::skin
