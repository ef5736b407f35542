#include "skin/anatomy/other_figures.h"

namespace backbend::skin {

std::vector<bool> nodes_of_other_figures(const Character& character, const Anatomy& anatomy) {
  std::vector<bool> out(character.nodes.size(), false);
  for (const int figure : anatomy.other_figures) out[static_cast<std::size_t>(figure)] = true;
  for (std::size_t n = 0; n < out.size(); ++n)  // parents stand first
    if (const int parent = character.nodes[n].parent; parent >= 0)
      out[n] = out[n] || out[static_cast<std::size_t>(parent)];
  return out;
}

std::vector<bool> vertices_of_other_figures(const Character& character, const Anatomy& anatomy) {
  std::vector<bool> out(character.vertex_count(), false);
  if (anatomy.other_figures.empty()) return out;
  const std::vector<bool> of_node = nodes_of_other_figures(character, anatomy);
  for (std::size_t v = 0; v < out.size(); ++v) {
    const auto joint = character.influences[v].joint[0];  // the largest weight stands first
    out[v] = of_node[static_cast<std::size_t>(character.joints[joint].node)];
  }
  return out;
}

}  // namespace backbend::skin
