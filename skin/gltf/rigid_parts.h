#pragma once
#include "skin/character/character.h"

namespace backbend::skin {

/// The character with its rigid parts (meshes on a node, such as a hat, a shield) bound where they
/// stand at rest, in the space in which the body is bound. Every pose is as it was, and a reader
/// that tells the rest from the bind matrices finds the parts in their places. Parts that a joint
/// of the body moves, and mirrored ones, stay as they are bound. Weights name joints of the
/// character.
Character with_rigid_parts_at_rest(Character character);

}  // namespace backbend::skin
