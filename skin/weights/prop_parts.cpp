#include "skin/weights/prop_parts.h"

#include "skin/character/part_owners.h"

namespace backbend::skin {

std::vector<int> prop_parts(const Character& character, const SkinPlaces& places) {
  using Index = std::size_t;
  std::vector<bool> leads_on(character.nodes.size(), false);  // a joint with weight hangs from it
  for (Index n = 0; n < character.nodes.size(); ++n)
    if (const int parent = character.nodes[n].parent; parent >= 0 && places.total[n] > 0.0)
      leads_on[static_cast<Index>(parent)] = true;
  std::vector<int> out = part_owners(character);
  for (int& node : out)
    if (node >= 0 &&
        (places.on_spine[static_cast<Index>(node)] >= 0 || leads_on[static_cast<Index>(node)]))
      node = -1;
  return out;
}

}  // namespace backbend::skin
