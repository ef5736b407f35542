#include "skin/character/part_owners.h"

namespace backbend::skin {

std::vector<int> part_owners(const Character& character) {
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
  for (Index part = 0; part < node_of.size(); ++part)
    if (node_of[part] < 0 || part_of[static_cast<Index>(node_of[part])] != static_cast<int>(part))
      node_of[part] = kNone;
  return node_of;
}

std::vector<bool> nodes_of_props(const Character& character) {
  using Index = std::size_t;
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
