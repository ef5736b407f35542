#include "skin/gltf/skin_layout.h"

#include <algorithm>
#include <limits>
#include <set>

#include "skin/character/matrix_facts.h"
#include "skin/gltf/bind_agreement.h"

namespace backbend::skin {
namespace {

using Index = std::size_t;

using Joints = std::set<Index>;  // numbers in Character::joints

Joints joints_of(const Part& part, const std::vector<WrittenInfluences>& influences,
                 Index joint_count) {
  Joints out;
  for (Index v = part.first_vertex; v < Index{part.first_vertex} + part.vertex_count; ++v)
    for (Index k = 0; k < static_cast<Index>(influences[v].count); ++k)
      if (influences[v].joint[k] < joint_count) out.insert(influences[v].joint[k]);
  return out;
}

/// In the space in which the part is bound.
BodyBox box_of(const Character& character, const Part& part) {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  BodyBox out{glm::dvec3(kFar), glm::dvec3(-kFar)};
  for (Index v = part.first_vertex; v < Index{part.first_vertex} + part.vertex_count; ++v) {
    out.low = glm::min(out.low, glm::dvec3(character.bind_position[v]));
    out.high = glm::max(out.high, glm::dvec3(character.bind_position[v]));
  }
  return out;
}

/// Skins under way.
class Skins {
 public:
  Skins(const Character& character, const std::vector<bool>& needs_node)
      : character_(character), needs_node_(needs_node) {}

  void open() {
    skins_.push_back({{}, std::vector<Index>(character_.nodes.size(), SkinLayout::kNone)});
  }
  Index size() const { return skins_.size(); }
  const Joints& joints(Index skin) const { return skins_[skin].joints; }
  /// Whether the skin binds none of these joints' nodes otherwise.
  bool takes(Index skin, const Joints& joints) const {
    return std::ranges::all_of(joints, [&](Index joint) {
      const Index held = skins_[skin].of_node[node(joint)];
      return needs_node_[joint] || held == SkinLayout::kNone || held == joint;
    });
  }
  /// Whether the skin has one of these joints, or one that moves what is in `box` as one of them
  /// does at rest.
  bool is_akin(Index skin, const Joints& joints, const BodyBox& box) const {
    return std::ranges::any_of(joints, [&](Index joint) {
      const glm::dmat4 motion = rest_motion(character_, joint);
      const double agree = kMotionsAgree * longest_axis(motion) * box.size();
      return std::ranges::any_of(skins_[skin].joints, [&](Index other) {
        return other == joint || apart(motion, rest_motion(character_, other), box) <= agree;
      });
    });
  }
  void add(Index skin, const Joints& joints) {
    for (const Index joint : joints) {
      skins_[skin].joints.insert(joint);
      if (!needs_node_[joint]) skins_[skin].of_node[node(joint)] = joint;
    }
  }

 private:
  struct Skin {
    Joints joints;
    std::vector<Index> of_node;  // [node] its joint
  };

  Index node(Index joint) const { return static_cast<Index>(character_.joints[joint].node); }

  const Character& character_;
  const std::vector<bool>& needs_node_;
  std::vector<Skin> skins_;
};

/// Whether no two of these joints are of one node, but for those with nodes of their own.
bool bind_each_node_once(const Character& character, const Joints& joints,
                         const std::vector<bool>& needs_node) {
  std::set<int> nodes;
  return std::ranges::all_of(joints, [&](Index joint) {
    return needs_node[joint] || nodes.insert(character.joints[joint].node).second;
  });
}

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
  std::vector<Joints> used;
  for (const Part& part : character.parts) {
    used.push_back(joints_of(part, influences, count));
    std::set<int> nodes;
    for (const Index joint : used.back())
      if (!nodes.insert(character.joints[joint].node).second) out.needs_node[joint] = true;
  }

  Joints all;
  for (const Joints& of_part : used) all.insert(of_part.begin(), of_part.end());
  const bool one_is_enough = bind_each_node_once(character, all, out.needs_node);

  Skins skins(character, out.needs_node);
  std::vector<BodyBox> box;  // of the first part of each skin
  for (Index p = 0; p < used.size(); ++p) {
    const BodyBox own = box_of(character, character.parts[p]);
    Index skin = 0;
    while (skin < skins.size() &&
           !(one_is_enough || used[p].empty() ||
             (skins.takes(skin, used[p]) && skins.is_akin(skin, used[p], own))))
      ++skin;
    if (skin == skins.size()) {
      skins.open();
      box.push_back(own);
    }
    skins.add(skin, used[p]);
    out.of_part.push_back(skin);
  }
  if (skins.size() == 0) {
    skins.open();
    box.emplace_back();
  }

  // The reader tells where a skin's mesh stands by the joint above most others, with vertices or
  // without.
  for (Index joint = 0; joint < count; ++joint) {
    if (all.contains(joint)) continue;
    for (Index skin = 0; skin < skins.size(); ++skin) {
      if (!skins.takes(skin, {joint})) continue;
      if (skins.size() > 1 && !skins.is_akin(skin, {joint}, box[skin])) continue;
      skins.add(skin, {joint});
      break;
    }
  }
  for (Index skin = 0; skin < skins.size(); ++skin)
    out.joints.emplace_back(skins.joints(skin).begin(), skins.joints(skin).end());
  return out;
}

}  // namespace backbend::skin
