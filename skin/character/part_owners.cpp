#include "skin/character/part_owners.h"

namespace backbend::skin {

using Index = std::size_t;

std::vector<int> part_owners(const Character& character) {
  std::vector<int> out(character.parts.size(), -1);
  std::vector<bool> shares(character.nodes.size(), false);  // a part with another node
  for (Index part = 0; part < out.size(); ++part) {
    const Index first = character.parts[part].first_vertex;
    for (Index v = first; v < first + character.parts[part].vertex_count; ++v) {
      const Influences& influences = character.influences[v];
      for (Index k = 0; k < kMaxInfluences && (k == 0 || influences.weight[k] > 0.0f); ++k) {
        const int node = character.joints[influences.joint[k]].node;
        if (out[part] < 0) out[part] = node;
        if (out[part] == node) continue;
        shares[static_cast<Index>(node)] = shares[static_cast<Index>(out[part])] = true;
      }
    }
  }
  for (int& node : out)
    if (node >= 0 && shares[static_cast<Index>(node)]) node = -1;
  return out;
}

std::vector<bool> nodes_of_props(const Character& character) {
  constexpr double kMost = 0.5;
  const std::vector<int> owner = part_owners(character);
  std::vector<bool> out(character.nodes.size(), false);
  double vertices = 0.0;
  for (Index part = 0; part < owner.size(); ++part) {
    if (owner[part] < 0) continue;
    out[static_cast<Index>(owner[part])] = true;
    vertices += character.parts[part].vertex_count;
  }
  if (vertices >= kMost * static_cast<double>(character.vertex_count()))
    return std::vector<bool>(out.size(), false);
  for (const SkinJoint& joint : character.joints)
    for (int above = character.nodes[static_cast<Index>(joint.node)].parent; above >= 0;
         above = character.nodes[static_cast<Index>(above)].parent)
      out[static_cast<Index>(above)] = false;
  return out;
}

}  // namespace backbend::skin
