#include "skin/character/part_owners.h"

#include <algorithm>

namespace backbend::skin {

namespace {

using Index = std::size_t;

/// Of each part, the node that alone moves it, else -1; and of each node, the parts that it moves.
struct PartMoves {
  std::vector<int> node_of;
  std::vector<std::vector<Index>> parts_of;
};

PartMoves part_moves(const Character& character) {
  constexpr int kNone = -1, kSeveral = -2;
  PartMoves out{std::vector<int>(character.parts.size(), kNone),
                std::vector<std::vector<Index>>(character.nodes.size())};
  for (Index part = 0; part < character.parts.size(); ++part) {
    int& known = out.node_of[part];
    const Index first = character.parts[part].first_vertex;
    for (Index v = first; v < first + character.parts[part].vertex_count; ++v) {
      const Influences& influences = character.influences[v];
      for (Index k = 0; k < kMaxInfluences && (k == 0 || influences.weight[k] > 0.0f); ++k) {
        const int node = character.joints[influences.joint[k]].node;
        if (known == kNone) known = node;
        if (known != node) known = kSeveral;
        std::vector<Index>& parts = out.parts_of[static_cast<Index>(node)];
        if (parts.empty() || parts.back() != part) parts.push_back(part);
      }
    }
    if (known == kSeveral) known = kNone;
  }
  return out;
}

}  // namespace

std::vector<int> part_owners(const Character& character) {
  PartMoves moves = part_moves(character);
  for (int& node : moves.node_of)
    if (node >= 0 && moves.parts_of[static_cast<Index>(node)].size() > 1) node = -1;
  return moves.node_of;
}

std::vector<bool> nodes_of_props(const Character& character) {
  constexpr double kMost = 0.5;
  const PartMoves moves = part_moves(character);
  std::vector<bool> out(character.nodes.size(), false);
  double vertices = 0.0;
  for (Index n = 0; n < out.size(); ++n) {
    const std::vector<Index>& parts = moves.parts_of[n];
    out[n] = !parts.empty() && std::ranges::all_of(parts, [&](Index part) {
      return moves.node_of[part] == static_cast<int>(n);
    });
    if (!out[n]) continue;
    for (const Index part : parts) vertices += character.parts[part].vertex_count;
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
