#include <algorithm>
#include <array>

#include "skin/anatomy/anatomy.h"

namespace backbend::skin {

std::string_view region_name(Region region) {
  constexpr std::array<std::string_view, kRegionCount> kNames = {
      "torso", "head", "arm_L", "arm_R", "leg_L", "leg_R", "tail", "other"};
  return kNames[static_cast<std::size_t>(region)];
}

std::vector<Region> node_regions(const Character& character, const Anatomy& anatomy) {
  constexpr int kInherit = -1;
  std::vector<int> of_node(character.nodes.size(), kInherit);
  const auto set = [&](int node, Region region) {
    if (node >= 0) of_node[static_cast<std::size_t>(node)] = static_cast<int>(region);
  };
  const auto set_root = [&](const std::vector<int>& chain, Region region) {
    if (!chain.empty()) set(chain.front(), region);
  };
  set_root(anatomy.tail, Region::tail);
  const std::size_t neck = std::max(anatomy.chest_index, anatomy.neck_index);
  const bool ends_in_head = anatomy.spine.back() == anatomy.head;
  for (std::size_t k = 0; k < anatomy.spine.size(); ++k)
    set(anatomy.spine[k], ends_in_head && k >= neck ? Region::head : Region::torso);
  set(anatomy.head, Region::head);
  set_root(anatomy.left_leg, Region::leg_left);
  set_root(anatomy.right_leg, Region::leg_right);
  set_root(anatomy.left_arm, Region::arm_left);
  set_root(anatomy.right_arm, Region::arm_right);

  for (std::size_t n = 0; n < of_node.size(); ++n) {  // parents stand before their children
    const int parent = character.nodes[n].parent;
    if (of_node[n] == kInherit)
      of_node[n] =
          parent < 0 ? static_cast<int>(Region::other) : of_node[static_cast<std::size_t>(parent)];
  }
  for (const Follower& follower : anatomy.followers) {
    std::vector<bool> below(of_node.size(), false);
    below[static_cast<std::size_t>(follower.node)] = true;
    for (std::size_t n = 0; n < of_node.size(); ++n) {
      const int parent = character.nodes[n].parent;
      below[n] = below[n] || (parent >= 0 && below[static_cast<std::size_t>(parent)]);
      if (below[n] && of_node[n] == static_cast<int>(Region::other))
        of_node[n] = of_node[static_cast<std::size_t>(follower.leader)];
    }
  }

  std::vector<Region> out;
  for (const int region : of_node) out.push_back(static_cast<Region>(region));
  return out;
}

std::vector<Region> vertex_regions(const Character& character, const Anatomy& anatomy) {
  const std::vector<Region> of_node = node_regions(character, anatomy);
  std::vector<Region> out(character.vertex_count());
  for (std::size_t v = 0; v < out.size(); ++v) {
    const auto joint = character.influences[v].joint[0];  // the largest weight stands first
    out[v] = of_node[static_cast<std::size_t>(character.joints[joint].node)];
  }
  return out;
}

}  // namespace backbend::skin
