#include "skin/gltf/rest_pose.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_inverse.hpp>
#include <limits>
#include <optional>

#include "skin/character/matrix_facts.h"
#include "skin/character/printable.h"
#include "skin/gltf/bind_agreement.h"
#include "solver/math/rotation.h"

namespace backbend::skin {
namespace {

constexpr double kPoseDiffers = 0.01;  // of the character's size: below, both poses are the rest
constexpr double kSameLength = 0.05;   // two bones of one length, relative
// Children of the root and IK targets are moved freely by animations, bones in a chain are not.
// Junk that describes no skeleton would match hardly ever; the worst real file (a snake) matches 71
// %.
constexpr double kMostBones = 0.5;
// Cosines of 0.05, 0.5 and 3 degrees. A mesh's node may hold anything, for readers of glTF leave it
// out: to turn a body by much it takes a root that leans for sure.
constexpr double kUpright = 1.0 - 4e-7, kAlongAxes = 0.99996, kLeans = 0.9986, kMuchDeg = 45.0;

/// Where the joints' bind matrices put the nodes; empty for nodes that no skin binds.
using BindPose = std::vector<std::optional<glm::dmat4>>;

BindPose bind_pose(const std::vector<Node>& nodes, const std::vector<BoundSkin>& skins) {
  BindPose bind(nodes.size());
  for (const BoundSkin& skin : skins)
    for (std::size_t j = 0; j < skin.node.size(); ++j) {
      auto& slot = bind[static_cast<std::size_t>(skin.node[j])];
      if (slot || !is_invertible(skin.joint_from_mesh[j])) continue;
      const glm::dmat4 world = skin.world_from_mesh * glm::affineInverse(skin.joint_from_mesh[j]);
      if (is_finite(world)) slot = world;
    }
  return bind;
}

/// The node whose frame moves `node`: the nearest bound ancestor.
int bound_parent(const std::vector<Node>& nodes, const BindPose& bind, std::size_t node) {
  int parent = nodes[node].parent;
  while (parent >= 0 && !bind[static_cast<std::size_t>(parent)])
    parent = nodes[static_cast<std::size_t>(parent)].parent;
  return parent;
}

/// The box of the vertices of a skin in the mesh's own space.
BodyBox box_of(const Character& character, const std::vector<int>& vertex_skin, int skin) {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  BodyBox box{glm::dvec3(kFar), glm::dvec3(-kFar)};
  for (std::size_t v = 0; v < character.vertex_count(); ++v) {
    if (vertex_skin[v] != skin) continue;
    box.low = glm::min(box.low, glm::dvec3(character.bind_position[v]));
    box.high = glm::max(box.high, glm::dvec3(character.bind_position[v]));
  }
  return box;
}

/// What is left of the bind poses of all skins' joints that were bound wrongly.
struct Misbound {
  bool others_agree = true;  // in every skin the node pose is the bind pose but for those
  std::vector<std::pair<int, glm::dmat4>> right;  // node, and where a right bind would have put it
};

Misbound find_misbound(const Character& character, const std::vector<BoundSkin>& skins,
                       const std::vector<int>& vertex_skin) {
  Misbound out;
  for (std::size_t s = 0; s < skins.size(); ++s) {
    const BoundSkin& skin = skins[s];
    const BodyBox box = box_of(character, vertex_skin, static_cast<int>(s));
    if (!(box.size() > 0.0)) continue;  // no vertex has it
    std::vector<BoundJoint> joints;
    for (std::size_t j = 0; j < skin.node.size(); ++j) {
      if (!is_invertible(skin.joint_from_mesh[j])) continue;
      const glm::dmat4 world =
          character.nodes[static_cast<std::size_t>(skin.node[j])].world_from_node *
          skin.joint_from_mesh[j];
      if (is_finite(world)) joints.push_back({skin.node[j], world});
    }
    const auto off = find_bind_off(character.nodes, joints, box);
    for (const BindOff& one : off) {
      if (!is_invertible(one.agreed)) continue;
      out.right.emplace_back(
          one.node, skin.world_from_mesh * glm::affineInverse(one.agreed) *
                        character.nodes[static_cast<std::size_t>(one.node)].world_from_node);
    }
    for (const BoundJoint& joint : joints) {
      const bool known = std::any_of(off.begin(), off.end(),
                                     [&](const BindOff& one) { return one.node == joint.node; });
      if (!known && apart(joint.world_from_mesh, skin.world_from_mesh, box) >
                        kPoseDiffers * longest_axis(skin.world_from_mesh) * box.size())
        out.others_agree = false;
    }
  }
  return out;
}

/// Whether a bone stands in its parent's frame at bind as it does in the nodes: where a clip's
/// first frame squashes and stretches joints, bones are of another length in the world alone.
bool same_in_parent(const glm::dmat4& parent_at_bind, const glm::dmat4& at_bind,
                    const glm::dmat4& parent_in_nodes, const glm::dmat4& in_nodes) {
  const glm::dvec3 bind(glm::inverse(parent_at_bind) * at_bind[3]);
  const glm::dvec3 node(glm::inverse(parent_in_nodes) * in_nodes[3]);
  const double length = glm::length(node);
  return length > 0.0 && glm::distance(bind, node) <= kSameLength * length;
}

/// Whether most bones are as long, and most joints as large, at bind as in the nodes, or stand in
/// their parents' frames alike.
bool is_skeleton(const std::vector<Node>& nodes, const BindPose& bind, double size) {
  std::size_t bones = 0, alike = 0;
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    const int parent = bind[n] ? bound_parent(nodes, bind, n) : -1;
    if (parent < 0) continue;
    const auto p = static_cast<std::size_t>(parent);
    const double at_bind = glm::distance(origin(*bind[n]), origin(*bind[p]));
    const double in_nodes =
        glm::distance(origin(nodes[n].world_from_node), origin(nodes[p].world_from_node));
    const double scale = longest_axis(*bind[n]) / longest_axis(nodes[n].world_from_node);
    const double slack = std::max(kSameLength * in_nodes, 0.2 * kPoseDiffers * size);
    ++bones;
    alike += (std::abs(at_bind - in_nodes) <= slack && std::abs(scale - 1.0) <= kSameLength) ||
             same_in_parent(*bind[p], *bind[n], nodes[p].world_from_node, nodes[n].world_from_node);
  }
  return bones == 0 || static_cast<double>(alike) >= kMostBones * static_cast<double>(bones);
}

/// Moves every bound node to its bind matrix; the others keep their place on their parent.
void move_to(std::vector<Node>& nodes, const BindPose& bind) {
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    Node& node = nodes[n];
    const glm::dmat4 parent = node.parent < 0
                                  ? glm::dmat4(1.0)
                                  : nodes[static_cast<std::size_t>(node.parent)].world_from_node;
    if (bind[n] && is_invertible(parent)) {
      node.world_from_node = *bind[n];
      node.parent_from_node = glm::affineInverse(parent) * *bind[n];
    } else {
      node.world_from_node = parent * node.parent_from_node;
    }
  }
}

/// Whether each axis of a frame lies along one of the world, as near as this cosine.
bool is_along_axes(const glm::dmat4& frame, double cosine) {
  for (int c = 0; c < 3; ++c) {
    const glm::dvec3 axis = glm::normalize(glm::dvec3(frame[c]));
    if (!(std::max({std::abs(axis.x), std::abs(axis.y), std::abs(axis.z)}) > cosine)) return false;
  }
  return true;
}

/// The angle that a motion of about size 1 turns by.
double degrees_of(const glm::dmat4& motion) {
  const double cosine = 0.5 * (motion[0][0] + motion[1][1] + motion[2][2] - 1.0);
  return solver::degrees(std::acos(std::clamp(cosine, -1.0, 1.0)));
}

/// The motion that takes the bind pose from the root, where a clip's first frame leans it, to where
/// the nodes of the meshes say that they were bound; nothing where they say another size, do not
/// agree, or stand askew themselves.
std::optional<glm::dmat4> stood_up(const Character& character, const std::vector<BoundSkin>& skins,
                                   const std::vector<int>& vertex_skin) {
  std::optional<glm::dmat4> out;
  for (std::size_t s = 0; s < skins.size(); ++s) {
    const BoundSkin& skin = skins[s];
    const BodyBox box = box_of(character, vertex_skin, static_cast<int>(s));
    if (!(box.size() > 0.0)) continue;  // no vertex has it
    if (skin.mesh_node < 0 || !is_invertible(skin.world_from_mesh)) return std::nullopt;
    const glm::dmat4& own =
        character.nodes[static_cast<std::size_t>(skin.mesh_node)].world_from_node;
    if (!is_invertible(own) || !is_along_axes(own, kAlongAxes)) return std::nullopt;
    const glm::dmat4 motion = own * glm::affineInverse(skin.world_from_mesh);
    if (is_along_axes(skin.world_from_mesh, degrees_of(motion) < kMuchDeg ? kUpright : kLeans))
      return std::nullopt;
    for (int c = 0; c < 3; ++c)
      if (std::abs(glm::length(glm::dvec3(motion[c])) - 1.0) > kSameLength) return std::nullopt;
    const double slack = kPoseDiffers * longest_axis(own) * box.size();
    if (glm::determinant(glm::dmat3(motion)) < 0.0 ||
        (out && apart(motion * skin.world_from_mesh, *out * skin.world_from_mesh, box) > slack))
      return std::nullopt;
    if (!out) out = motion;
  }
  return out;
}

struct Spread {
  double size = 0.0;      // largest extent of the mesh at bind
  double farthest = 0.0;  // of any vertex between bind pose and node pose
};

Spread measure(const Character& character, const std::vector<BoundSkin>& skins,
               const std::vector<int>& vertex_skin) {
  std::vector<glm::dmat4> world_from_mesh(character.joints.size());
  for (std::size_t j = 0; j < character.joints.size(); ++j)
    world_from_mesh[j] = rest_motion(character, j);

  constexpr double kFar = std::numeric_limits<double>::infinity();
  glm::dvec3 low(kFar), high(-kFar);
  Spread out;
  for (std::size_t v = 0; v < character.vertex_count(); ++v) {
    if (vertex_skin[v] < 0) continue;
    const glm::dvec4 mesh(glm::dvec3(character.bind_position[v]), 1.0);
    const glm::dvec3 bound(skins[static_cast<std::size_t>(vertex_skin[v])].world_from_mesh * mesh);
    low = glm::min(low, bound);
    high = glm::max(high, bound);
    const Influences& influences = character.influences[v];
    if (!(influences.weight[0] > 0.0f)) continue;
    glm::dvec3 posed(0.0);
    for (int k = 0; k < kMaxInfluences; ++k)
      if (influences.weight[static_cast<std::size_t>(k)] > 0.0f)
        posed += static_cast<double>(influences.weight[static_cast<std::size_t>(k)]) *
                 glm::dvec3(world_from_mesh[influences.joint[static_cast<std::size_t>(k)]] * mesh);
    out.farthest = std::max(out.farthest, glm::distance(posed, bound));
  }
  if (low.x <= high.x) out.size = std::max({high.x - low.x, high.y - low.y, high.z - low.z});
  return out;
}

}  // namespace

glm::dmat4 place_at_bind(const std::vector<Node>& nodes, const BoundSkin& skin) {
  std::vector<int> below(nodes.size(), 0);
  for (const int node : skin.node) ++below[static_cast<std::size_t>(node)];
  for (std::size_t n = nodes.size(); n-- > 0;)  // children stand behind their parents
    if (nodes[n].parent >= 0) below[static_cast<std::size_t>(nodes[n].parent)] += below[n];

  int most = 0;
  glm::dmat4 best(1.0);
  for (std::size_t j = 0; j < skin.node.size(); ++j) {
    const auto node = static_cast<std::size_t>(skin.node[j]);
    if (below[node] <= most || !is_invertible(skin.joint_from_mesh[j])) continue;
    const glm::dmat4 place = nodes[node].world_from_node * skin.joint_from_mesh[j];
    if (!is_finite(place)) continue;
    most = below[node];
    best = place;
  }
  return best;
}

std::vector<Warning> settle_rest_pose(Character& character, std::vector<BoundSkin>& skins,
                                      const std::vector<int>& vertex_skin) {
  const Spread spread = measure(character, skins, vertex_skin);
  if (!(spread.farthest > kPoseDiffers * spread.size)) return {};
  const std::string apart =
      number_text(100.0 * spread.farthest / spread.size, 3) + " % of the character's size apart";
  // A joint that was bound wrongly stays where its node stands against its neighbours, so that the
  // fault is seen: were the bind pose taken for the rest, it would be gone.
  const Misbound misbound = find_misbound(character, skins, vertex_skin);
  if (misbound.others_agree && !misbound.right.empty()) return {};
  BindPose bind = bind_pose(character.nodes, skins);
  if (!is_skeleton(character.nodes, bind, spread.size))
    return {{"bind_pose_unusable", "node pose and inverse binds are " + apart +
                                       " and the binds describe no skeleton: the node pose is "
                                       "taken as the rest"}};
  for (const auto& [node, world] : misbound.right) bind[static_cast<std::size_t>(node)] = world;
  std::string stands;
  if (const auto motion = stood_up(character, skins, vertex_skin)) {
    stands = ", stood up by " + number_text(degrees_of(*motion), 2) +
             " deg as the nodes of the meshes stand";
    for (BoundSkin& skin : skins) skin.world_from_mesh = *motion * skin.world_from_mesh;
    for (auto& world : bind)
      if (world) world = *motion * *world;
  }
  move_to(character.nodes, bind);
  return {{"rest_is_bind_pose", "the node pose and the pose the skin was bound in are " + apart +
                                    ": the bind pose is taken as the rest" + stands}};
}

}  // namespace backbend::skin
