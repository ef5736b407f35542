#include "skin/character/ancestor.h"

namespace backbend::skin {

bool is_ancestor(const Character& character, int above, int below) {
  while (below >= 0 && below != above)
    below = character.nodes[static_cast<std::size_t>(below)].parent;
  return below == above && above >= 0;
}

}  // namespace backbend::skin
