#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "skin/character/matrix_facts.h"
#include "skin/deform/skinning.h"
#include "tests/battery/body_variants.h"

namespace backbend::battery {
namespace {

using Index = std::size_t;
using skin::Character;

constexpr double kLeastVertices = 6.0;  // of a piece of a bone

/// Sets a new node before the others' children keep their order: parents stand before children.
int insert_node(Character& body, int after, skin::Node node) {
  const int place = after + 1;
  for (skin::Node& each : body.nodes)
    if (each.parent >= place) ++each.parent;
  for (skin::SkinJoint& joint : body.joints)
    if (joint.node >= place) ++joint.node;
  body.nodes.insert(body.nodes.begin() + place, std::move(node));
  return place;
}

void remove_node(Character& body, int node) {
  const int parent = body.nodes[static_cast<Index>(node)].parent;
  for (skin::Node& each : body.nodes) {
    if (each.parent == node) {
      each.parent = parent;
      each.parent_from_node = glm::inverse(body.nodes[static_cast<Index>(parent)].world_from_node) *
                              each.world_from_node;
    }
  }
  for (skin::Node& each : body.nodes)
    if (each.parent > node) --each.parent;
  for (skin::SkinJoint& joint : body.joints)
    if (joint.node > node) --joint.node;
  body.nodes.erase(body.nodes.begin() + node);
}

/// Cuts the bone from a joint to its child into `pieces`, in even lengths; the joint's weights go
/// over to the new ones along the bone, smoothly from the middle of one piece to the next's.
void cut_bone(Character& body, int low, int high, Index pieces, std::vector<int>& chain) {
  if (pieces < 2) return;
  const glm::dvec3 start = skin::origin(body.nodes[static_cast<Index>(low)].world_from_node);
  const glm::dvec3 bone =
      skin::origin(body.nodes[static_cast<Index>(high)].world_from_node) - start;
  std::vector<std::uint16_t> piece = {skin_joint(body, low)};
  const glm::dmat4 world_from_mesh =
      body.nodes[static_cast<Index>(low)].world_from_node * body.joints[piece[0]].joint_from_mesh;
  const glm::dmat4 high_world = body.nodes[static_cast<Index>(high)].world_from_node;
  const std::string name = body.nodes[static_cast<Index>(low)].name;
  int parent = low;
  for (Index k = 1; k < pieces; ++k) {
    skin::Node node;
    node.name = name + "_part" + std::to_string(k);
    node.parent = parent;
    node.world_from_node = body.nodes[static_cast<Index>(low)].world_from_node;
    node.world_from_node[3] =
        glm::dvec4(start + bone * (static_cast<double>(k) / static_cast<double>(pieces)), 1.0);
    node.parent_from_node =
        glm::inverse(body.nodes[static_cast<Index>(parent)].world_from_node) * node.world_from_node;
    const glm::dmat4 world = node.world_from_node;
    const int place = insert_node(body, parent, std::move(node));
    for (int& each : chain)
      if (each >= place) ++each;
    if (high >= place) ++high;
    body.joints.push_back({place, glm::inverse(world) * world_from_mesh});
    piece.push_back(static_cast<std::uint16_t>(body.joints.size() - 1));
    parent = place;
  }
  skin::Node& end = body.nodes[static_cast<Index>(high)];
  end.parent = parent;
  end.parent_from_node =
      glm::inverse(body.nodes[static_cast<Index>(parent)].world_from_node) * high_world;
  const double squared = glm::dot(bone, bone);
  for (Index v = 0; v < body.vertex_count(); ++v) {
    JointWeights weights = weights_of(body.influences[v]);
    const auto own = weights.find(piece[0]);
    if (own == weights.end()) continue;
    const double amount = own->second;
    weights.erase(own);
    const glm::dvec3 p(world_from_mesh * glm::dvec4(glm::dvec3(body.bind_position[v]), 1.0));
    const double u = glm::dot(p - start, bone) / squared * static_cast<double>(pieces) - 0.5;
    const double at = std::clamp(u, 0.0, static_cast<double>(pieces - 1));
    const Index below = std::min(static_cast<Index>(at), pieces - 2);
    const double t = at - static_cast<double>(below), share = t * t * (3.0 - 2.0 * t);
    weights[piece[below]] += amount * (1.0 - share);
    weights[piece[below + 1]] += amount * share;
    body.influences[v] = influences_of(weights, skin::kMaxInfluences);
  }
}

double mass(const Character& body, int node) {
  double sum = 0.0;
  for (const skin::Influences& each : body.influences)
    for (Index k = 0; k < skin::kMaxInfluences && each.weight[k] > 0.0f; ++k)
      if (body.joints[each.joint[k]].node == node) sum += each.weight[k];
  return sum;
}

/// Mean length of the edges that a joint moves, in the world.
double usual_edge(const Character& body, int node) {
  const std::uint16_t joint = [&] {
    for (Index j = 0; j < body.joints.size(); ++j)
      if (body.joints[j].node == node) return static_cast<std::uint16_t>(j);
    return std::uint16_t{0xffff};
  }();
  const auto moved = [&](Index v) {
    const JointWeights weights = weights_of(body.influences[v]);
    const auto found = weights.find(joint);
    return found != weights.end() && found->second > 0.3;
  };
  const std::vector<glm::vec3> rest = skin::rest_mesh(body).position;
  double sum = 0.0, count = 0.0;
  for (const glm::uvec3& t : body.triangles)
    for (int i = 0; i < 3; ++i) {
      const Index a = t[i], b = t[(i + 1) % 3];
      if (!moved(a) || !moved(b)) continue;
      sum += glm::distance(glm::dvec3(rest[a]), glm::dvec3(rest[b]));
      count += 1.0;
    }
  return count > 0.0 ? sum / count : 0.0;
}

/// Gives a joint's weights and children to its parent.
void merge_joint(Character& body, int node) {
  const std::uint16_t own = skin_joint(body, node);
  const std::uint16_t heir = skin_joint(body, body.nodes[static_cast<Index>(node)].parent);
  for (skin::Influences& each : body.influences) {
    JointWeights weights = weights_of(each);
    const auto found = weights.find(own);
    if (found == weights.end()) continue;
    weights[heir] += found->second;
    weights.erase(own);
    each = influences_of(weights, skin::kMaxInfluences);
  }
  body.joints.erase(body.joints.begin() + own);
  for (skin::Influences& each : body.influences)
    for (Index k = 0; k < skin::kMaxInfluences; ++k)
      if (each.weight[k] > 0.0f && each.joint[k] > own) --each.joint[k];
  remove_node(body, node);
}

}  // namespace

std::size_t resample_spine(Character& body, const skin::Anatomy& anatomy, std::size_t wanted) {
  std::vector<int> chain = hips_to_chest(body, anatomy);
  // A chain that is built from the chest backwards is not to be cut this way.
  for (Index k = 1; k < chain.size(); ++k)
    if (body.nodes[static_cast<Index>(chain[k])].parent != chain[k - 1]) return chain.size();
  const auto length = [&](Index k) {  // of the bone below joint k of the chain
    return glm::distance(skin::origin(body.nodes[static_cast<Index>(chain[k - 1])].world_from_node),
                         skin::origin(body.nodes[static_cast<Index>(chain[k])].world_from_node));
  };
  while (chain.size() > wanted && chain.size() > 2) {
    Index shortest = 1;
    for (Index k = 2; k + 1 < chain.size(); ++k)
      if (length(k) < length(shortest)) shortest = k;
    const int node = chain[shortest];
    chain.erase(chain.begin() + static_cast<std::ptrdiff_t>(shortest));
    for (int& each : chain)
      if (each > node) --each;
    merge_joint(body, node);
  }
  std::vector<Index> pieces(chain.size(), 1);  // of the bone below each joint
  // A bone of a coarse body has only so many vertices to share out: pieces without are no spine.
  std::vector<double> vertices(chain.size(), 0.0);
  for (Index k = 1; k < chain.size(); ++k) vertices[k] = mass(body, chain[k - 1]);
  std::vector<double> edge(chain.size(), 0.0);  // usual length on the surface that it moves
  for (Index k = 1; k < chain.size(); ++k) edge[k] = usual_edge(body, chain[k - 1]);
  const auto can_be_cut = [&](Index k) {
    const double count = static_cast<double>(pieces[k] + 1);
    return vertices[k] >= kLeastVertices * count && length(k) >= edge[k] * count;
  };
  for (Index count = chain.size(); count < wanted; ++count) {
    Index longest = 0;
    for (Index k = 1; k < chain.size(); ++k)
      if (can_be_cut(k) &&
          (longest == 0 || length(k) / static_cast<double>(pieces[k]) >
                               length(longest) / static_cast<double>(pieces[longest])))
        longest = k;
    if (longest == 0) break;
    ++pieces[longest];
  }
  // From the top down, so that the bones below keep their joints.
  Index total = chain.size();
  for (Index k = chain.size(); k-- > 1;) {
    cut_bone(body, chain[k - 1], chain[k], pieces[k], chain);
    total += pieces[k] - 1;
  }
  renew_world(body);
  return total;
}

}  // namespace backbend::battery
