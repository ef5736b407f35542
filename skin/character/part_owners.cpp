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
  constexpr int kLeastBody = 6;  // joints of a body: hips, chest and one of each limb
  const std::vector<int> owner = part_owners(character);
  std::vector<bool> owns(character.nodes.size(), false), moves(character.nodes.size(), false);
  double vertices = 0.0;
  for (Index part = 0; part < owner.size(); ++part) {
    if (owner[part] < 0) continue;
    owns[static_cast<Index>(owner[part])] = true;
    vertices += character.parts[part].vertex_count;
  }
  for (const Influences& influences : character.influences)
    for (Index k = 0; k < kMaxInfluences && influences.weight[k] > 0.0f; ++k)
      moves[static_cast<Index>(character.joints[influences.joint[k]].node)] = true;
  std::vector<bool> props = owns;
  for (const SkinJoint& joint : character.joints)
    for (int above = character.nodes[static_cast<Index>(joint.node)].parent; above >= 0;
         above = character.nodes[static_cast<Index>(above)].parent)
      props[static_cast<Index>(above)] = false;
  if (vertices < 0.5 * static_cast<double>(character.vertex_count())) return props;
  // A few finely modelled weapons have more vertices than the body that carries them.
  int body = 0, rigid = 0;
  for (Index n = 0; n < props.size(); ++n) {
    if (!moves[n] || props[n]) continue;
    ++body;
    if (owns[n]) ++rigid;
  }
  return body >= kLeastBody && 2 * rigid < body ? props : std::vector<bool>(props.size(), false);
}

}  // namespace backbend::skin
