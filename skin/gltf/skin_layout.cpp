#include "skin/gltf/skin_layout.h"

#include <algorithm>
#include <set>

namespace backbend::skin {
namespace {

using Index = std::size_t;

std::set<Index> joints_of(const Part& part, const std::vector<WrittenInfluences>& influences,
                          Index joint_count) {
  std::set<Index> out;
  for (Index v = part.first_vertex; v < Index{part.first_vertex} + part.vertex_count; ++v)
    for (Index k = 0; k < static_cast<Index>(influences[v].count); ++k)
      if (influences[v].joint[k] < joint_count) out.insert(influences[v].joint[k]);
  return out;
}

/// Skins under way: which joint each has for a node.
class Skins {
 public:
  Skins(const Character& character, const std::vector<bool>& needs_node)
      : character_(character), needs_node_(needs_node) {}

  Index size() const { return of_node_.size(); }
  void open() { of_node_.emplace_back(character_.nodes.size(), SkinLayout::kNone); }
  bool takes(Index skin, Index joint) const {
    const Index held = of_node_[skin][node(joint)];
    return needs_node_[joint] || held == SkinLayout::kNone || held == joint;
  }
  void put(Index skin, Index joint) {
    if (!needs_node_[joint]) of_node_[skin][node(joint)] = joint;
  }

 private:
  Index node(Index joint) const { return static_cast<Index>(character_.joints[joint].node); }

  const Character& character_;
  const std::vector<bool>& needs_node_;
  std::vector<std::vector<Index>> of_node_;  // [skin][node]
};

}  // namespace

Index SkinLayout::place(Index skin, Index joint) const {
  const auto found = std::ranges::lower_bound(joints[skin], joint);
  return found != joints[skin].end() && *found == joint
             ? static_cast<Index>(found - joints[skin].begin())
             : kNone;
}

SkinLayout lay_out_skins(const Character& character,
                         const std::vector<WrittenInfluences>& influences) {
  const Index count = character.joints.size();
  SkinLayout out;
  out.needs_node.assign(count, false);
  std::vector<std::set<Index>> used;
  for (const Part& part : character.parts) {
    used.push_back(joints_of(part, influences, count));
    std::set<int> nodes;
    for (const Index joint : used.back())
      if (!nodes.insert(character.joints[joint].node).second) out.needs_node[joint] = true;
  }

  Skins skins(character, out.needs_node);
  std::vector<std::set<Index>> joints;
  const auto put = [&](Index skin, Index joint) {
    skins.put(skin, joint);
    joints[skin].insert(joint);
  };
  const auto open = [&] {
    skins.open();
    joints.emplace_back();
  };
  open();
  for (const std::set<Index>& of_part : used) {
    Index skin = 0;
    const auto fits = [&](Index joint) { return skins.takes(skin, joint); };
    while (skin < skins.size() && !std::ranges::all_of(of_part, fits)) ++skin;
    if (skin == skins.size()) open();
    for (const Index joint : of_part) put(skin, joint);
    out.of_part.push_back(skin);
  }

  // A file's joints come skin by skin: one without vertices was read beside the one before it.
  Index last = 0;
  for (Index joint = 0; joint < count; ++joint) {
    Index home = SkinLayout::kNone;
    for (Index skin = 0; skin < joints.size(); ++skin)
      if (joints[skin].contains(joint)) home = std::min(home, skin);
    if (home == SkinLayout::kNone) {
      home = last;
      if (!skins.takes(home, joint))
        for (home = 0; home < skins.size() && !skins.takes(home, joint);) ++home;
      if (home == skins.size()) continue;
      put(home, joint);
    }
    last = home;
  }
  for (const std::set<Index>& of_skin : joints)
    out.joints.emplace_back(of_skin.begin(), of_skin.end());
  return out;
}

}  // namespace backbend::skin
