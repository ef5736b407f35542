#include "skin/gltf/usd_skeleton.h"

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/matrix.hpp>
#include <set>

#include "skin/character/matrix_facts.h"
#include "skin/character/printable.h"
#include "skin/gltf/usd_names.h"

namespace backbend::skin {
namespace {

/// A joint beside the nodes: it stands on `parent` (-1: on the skeleton) and never moves there.
std::size_t add_joint(UsdSkeleton& skeleton, UniqueNames& paths, UniqueNames& names, int parent,
                      const std::string& name) {
  const std::string word = paths.take(usd_identifier(name, "joint"));
  skeleton.path.push_back(
      parent < 0 ? word : skeleton.path[static_cast<std::size_t>(parent)] + "/" + word);
  skeleton.name.push_back(names.take(name));
  return skeleton.path.size() - 1;
}

std::vector<glm::dmat4> rest_in_skeleton(const Character& character,
                                         const std::vector<NodeTransform>& rest) {
  std::vector<glm::dmat4> world;
  for (std::size_t i = 0; i < rest.size(); ++i) {
    const int parent = character.nodes[i].parent;
    const glm::dmat4 local = matrix_of(rest[i]);
    world.push_back(parent < 0 ? local : world[static_cast<std::size_t>(parent)] * local);
  }
  return world;
}

/// Whether a node moves vertices, or one below it does.
std::vector<bool> nodes_of_skin(const Character& character) {
  std::vector<bool> needed(character.nodes.size(), false);
  for (const SkinJoint& joint : character.joints)
    needed[static_cast<std::size_t>(joint.node)] = true;
  for (std::size_t i = needed.size(); i-- > 0;)
    if (const int parent = character.nodes[i].parent; needed[i] && parent >= 0)
      needed[static_cast<std::size_t>(parent)] = true;
  return needed;
}

/// Adds the joints of the nodes that the skin needs; the joint of each node, -1: none. Where they
/// have several roots, or `one_more` stands beside them, they get a common one: readers expect it.
std::vector<int> add_node_joints(UsdSkeleton& out, UniqueNames& paths, UniqueNames& names,
                                 const Character& character, const WrittenSkeleton& written,
                                 bool one_more) {
  const std::vector<bool> needed = nodes_of_skin(character);
  const std::vector<glm::dmat4> world = rest_in_skeleton(character, written.rest);
  std::size_t roots = one_more ? 1 : 0;
  for (std::size_t i = 0; i < needed.size(); ++i)
    roots += needed[i] && character.nodes[i].parent < 0;
  out.frames.resize(written.frames.size());
  int root = -1;
  if (roots > 1) {
    root = static_cast<int>(add_joint(out, paths, names, -1, "character"));
    out.bind.emplace_back(1.0);
    out.rest.emplace_back();
    for (std::vector<NodeTransform>& frame : out.frames) frame.emplace_back();
  }
  std::vector<int> joint_of(needed.size(), -1);
  for (std::size_t i = 0; i < needed.size(); ++i) {
    if (!needed[i]) continue;
    const int parent = character.nodes[i].parent;
    const int above = parent < 0 ? root : joint_of[static_cast<std::size_t>(parent)];
    joint_of[i] = static_cast<int>(add_joint(out, paths, names, above, character.nodes[i].name));
    out.bind.push_back(world[i]);
    out.rest.push_back(written.rest[i]);
    for (std::size_t f = 0; f < out.frames.size(); ++f)
      out.frames[f].push_back(written.frames[f][i]);
  }
  return joint_of;
}

}  // namespace

glm::dmat4 matrix_of(const NodeTransform& t) {
  return glm::translate(glm::dmat4(1.0), t.translation) * glm::mat4_cast(t.rotation) *
         glm::scale(glm::dmat4(1.0), t.scale);
}

UsdSkeleton usd_skeleton(const Character& character, const GlbAnimation& animation,
                         bool unskinned) {
  const WrittenSkeleton written = prepare_skeleton(character, &animation, JointFrames::rigid);
  UsdSkeleton out;
  UniqueNames paths, names;
  const std::vector<int> joint_of =
      add_node_joints(out, paths, names, character, written, unskinned);
  for (std::size_t j = 0; j < character.joints.size(); ++j) {
    const auto node = static_cast<std::size_t>(character.joints[j].node);
    if (!is_invertible(written.joint_from_mesh[j]))
      throw CharacterError(character.file_name + ": joint " +
                           in_quotes(character.nodes[node].name) +
                           ": its inverse bind matrix cannot be inverted, which USD's bind "
                           "transforms need");
    if (j == 0)
      out.geom_bind =
          out.bind[static_cast<std::size_t>(joint_of[node])] * written.joint_from_mesh[0];
  }
  std::set<int> bound;
  for (std::size_t j = 0; j < character.joints.size(); ++j) {
    const auto node = static_cast<std::size_t>(character.joints[j].node);
    auto joint = static_cast<std::size_t>(joint_of[node]);
    if (!bound.insert(joint_of[node]).second) {
      // A joint has one bind transform; a second one hangs on a joint that stands on the first.
      joint = add_joint(out, paths, names, joint_of[node],
                        character.nodes[node].name + "_bind_" + std::to_string(j));
      out.bind.emplace_back();
    }
    out.of_skin.push_back(joint);
    out.bind[joint] = out.geom_bind * glm::inverse(written.joint_from_mesh[j]);
  }
  if (unskinned) {
    out.of_skin.push_back(add_joint(out, paths, names, 0, "unskinned"));
    out.bind.push_back(out.geom_bind);
  }
  out.rest.resize(out.path.size());
  for (std::vector<NodeTransform>& frame : out.frames) frame.resize(out.path.size());
  return out;
}

}  // namespace backbend::skin
