#include "skin/weights/prop_parts.h"

#include <algorithm>

namespace backbend::skin {

std::vector<bool> prop_parts(const Character& character, const SkinPlaces& places) {
  using Index = std::size_t;
  constexpr int kNone = -1, kSeveral = -2;
  const auto add = [](int& known, int one) {
    if (known == kNone) known = one;
    if (known != one) known = kSeveral;
  };
  std::vector<int> node_of(character.parts.size(), kNone);  // the one that moves a part
  std::vector<int> part_of(character.nodes.size(), kNone);  // the one that a node moves
  for (Index part = 0; part < character.parts.size(); ++part) {
    const Index first = character.parts[part].first_vertex;
    for (Index v = first; v < first + character.parts[part].vertex_count; ++v) {
      const Influences& influences = character.influences[v];
      for (Index k = 0; k < kMaxInfluences && (k == 0 || influences.weight[k] > 0.0f); ++k) {
        const int node = character.joints[influences.joint[k]].node;
        add(node_of[part], node);
        add(part_of[static_cast<Index>(node)], static_cast<int>(part));
      }
    }
  }
  std::vector<bool> out(character.parts.size(), false);
  for (Index part = 0; part < out.size(); ++part) {
    const int node = node_of[part];
    out[part] = node >= 0 && part_of[static_cast<Index>(node)] == static_cast<int>(part) &&
                places.on_spine[static_cast<Index>(node)] < 0;
  }
  for (Index n = 0; n < character.nodes.size(); ++n) {
    const int parent = character.nodes[n].parent;
    if (parent < 0 || !(places.total[n] > 0.0)) continue;
    if (const int part = part_of[static_cast<Index>(parent)]; part >= 0)
      out[static_cast<Index>(part)] = false;
  }
  return out;
}

}  // namespace backbend::skin
