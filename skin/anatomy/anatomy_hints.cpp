#include "skin/anatomy/anatomy_hints.h"

#include <algorithm>
#include <string_view>
#include <unordered_map>

#include "skin/anatomy/skeleton_shape.h"
#include "skin/character/joint_names.h"
#include "skin/character/printable.h"
#include "solver/rig/nearest_name.h"

namespace backbend::skin {
namespace {

std::vector<int> chain_of(const Character& character, const std::vector<std::string>& names,
                          const char* what) {
  std::vector<int> chain;
  for (const std::string& name : names) {
    const int node = node_named(character, name);
    // An arm may stand beside its clavicle, where a file has deforming joints alone.
    const bool beside = chain.size() == 1 &&
                        read_joint_name(names.front()).part == BodyPart::clavicle &&
                        read_joint_name(name).part == BodyPart::arm;
    // Some skeletons are built from the head or the chest: a chain may run up the tree, too.
    if (!chain.empty() && !beside &&
        (node == chain.back() || (path_down(character, chain.back(), node).empty() &&
                                  path_down(character, node, chain.back()).empty())))
      throw CharacterError(character.file_name + ": " + what + ": " + in_quotes(name) +
                           " does not hang from " +
                           in_quotes(character.nodes[static_cast<std::size_t>(chain.back())].name));
    chain.push_back(node);
  }
  return chain;
}

std::string without_namespaces(const std::string& name) {
  return name.substr(name.find_last_of(":|") + 1);
}

/// By node.
std::vector<bool> are_joints(const Character& character) {
  std::vector<bool> is_joint(character.nodes.size(), false);
  for (const SkinJoint& joint : character.joints)
    is_joint[static_cast<std::size_t>(joint.node)] = true;
  return is_joint;
}

/// Nodes for which `is` holds: joints alone where there are any among them.
template <typename Test>
std::vector<int> nodes_that(const Character& character, const Test& is) {
  const std::vector<bool> is_joint = are_joints(character);
  std::vector<int> all, joints;
  for (std::size_t n = 0; n < character.nodes.size(); ++n) {
    if (!is(character.nodes[n])) continue;
    all.push_back(static_cast<int>(n));
    if (is_joint[n]) joints.push_back(static_cast<int>(n));
  }
  return joints.empty() ? all : joints;
}

}  // namespace

int node_named(const Character& character, const std::string& name) {
  auto found = nodes_that(character, [&](const Node& node) { return node.name == name; });
  if (found.empty() && name.size() > 1 && name[0] == '#')
    found = nodes_that(
        character, [&](const Node& node) { return name == "#" + std::to_string(node.file_node); });
  const std::string bare = without_namespaces(name);
  if (found.empty() && !bare.empty())
    found = nodes_that(character,
                       [&](const Node& node) { return without_namespaces(node.name) == bare; });
  if (found.size() == 1) return found.front();
  if (found.size() > 1)
    throw CharacterError(
        character.file_name + ": several joints are called " + in_quotes(name) +
        "; name one by its number, such as #" +
        std::to_string(character.nodes[static_cast<std::size_t>(found.front())].file_node));
  std::vector<std::string> names;
  for (const Node& node : character.nodes) names.push_back(node.name);
  const std::string_view nearest = solver::nearest_name(name, names);
  throw CharacterError(character.file_name + ": no joint is called " + in_quotes(name) +
                       (nearest.empty() ? "; backbend inspect shows all"
                                        : "; the nearest is " + in_quotes(nearest)));
}

std::vector<std::string> reference_names(const Character& character) {
  const std::vector<bool> is_joint = are_joints(character);
  struct Bearers {
    int joints = 0, others = 0;
  };
  std::unordered_map<std::string_view, Bearers> bearers;
  for (std::size_t n = 0; n < character.nodes.size(); ++n) {
    Bearers& of_name = bearers[character.nodes[n].name];
    ++(is_joint[n] ? of_name.joints : of_name.others);
  }
  std::vector<std::string> names;
  for (std::size_t n = 0; n < character.nodes.size(); ++n) {
    const Node& node = character.nodes[n];
    const Bearers& same = bearers[node.name];
    const bool alone = is_joint[n] ? same.joints == 1 : same.joints == 0 && same.others == 1;
    names.push_back(alone ? node.name : "#" + std::to_string(node.file_node));
  }
  return names;
}

std::string reference_name(const Character& character, int node) {
  return reference_names(character)[static_cast<std::size_t>(node)];
}

std::vector<int> path_between(const Character& character, int from, int to) {
  std::vector<int> up;
  for (int n = from; n >= 0; n = character.nodes[static_cast<std::size_t>(n)].parent) {
    const auto down = path_down(character, n, to);
    up.push_back(n);
    if (down.empty()) continue;
    up.insert(up.end(), down.begin() + 1, down.end());
    return up;
  }
  return {};
}

HintedSpine resolve_spine_hints(const Character& character, const AnatomyHints& hints) {
  HintedSpine out;
  if (!hints.hip.empty()) out.hip = node_named(character, hints.hip);
  if (!hints.chest.empty()) out.chest = node_named(character, hints.chest);
  out.chain = chain_of(character, hints.spine, "--spine");
  if (out.chain.size() == 1)
    throw CharacterError(character.file_name + ": --spine: expected two joints or more");
  if (!out.chain.empty() && out.chest >= 0 &&
      std::find(out.chain.begin() + 1, out.chain.end(), out.chest) == out.chain.end())
    throw CharacterError(character.file_name + ": --chest: " + in_quotes(hints.chest) +
                         " is not in the spine given");
  return out;
}

HintedArms resolve_arm_hints(const Character& character, const AnatomyHints& hints) {
  return {chain_of(character, hints.left_arm, "--arms"),
          chain_of(character, hints.right_arm, "--arms")};
}

}  // namespace backbend::skin
