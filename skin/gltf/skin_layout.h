#pragma once
#include <cstddef>
#include <vector>

#include "skin/character/character.h"
#include "skin/gltf/written_influences.h"

namespace backbend::skin {

/// The skins that a character is written with: a skin binds each node once, so parts that are bound
/// in several spaces have several.
struct SkinLayout {
  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);

  std::vector<std::vector<std::size_t>> joints;  // [skin] numbers in Character::joints
  std::vector<std::size_t> of_part;              // [part] its skin
  /// [joint of the character] Whether one part goes by it and by another joint of its node: it
  /// needs a node of its own.
  std::vector<bool> needs_node;

  /// The place of a joint in a skin's list; kNone where the skin lacks it.
  std::size_t place(std::size_t skin, std::size_t joint) const;
};

/// `influences` are written_skin()'s. As few skins as the parts, taken in order, allow; at least
/// one. Of several, a joint without vertices is in one whose mesh it would move as the skin's other
/// joints do at rest, or in none.
SkinLayout lay_out_skins(const Character& character,
                         const std::vector<WrittenInfluences>& influences);

}  // namespace backbend::skin
