#include "validate/metrics/surface/torso.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>

#include "skin/character/closest_point.h"
#include "validate/metrics/surface/connected_pieces.h"

namespace backbend::validate {
namespace {

// A clavicle starts next to the spine: nearer than this share of the whole arm's reach.
constexpr double kClavicleShare = 0.18;
// Legs within 45 degrees of the spine's direction run on from it.
constexpr double kAlong = 0.7;

glm::dvec3 origin(const skin::Character& character, int node) {
  return glm::dvec3(character.nodes[static_cast<std::size_t>(node)].world_from_node[3]);
}

double distance_to_spine(const skin::Character& character, const skin::Anatomy& anatomy, int node) {
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t k = 1; k < anatomy.spine.size(); ++k)
    nearest = std::min(nearest, skin::distance_to_segment(origin(character, node),
                                                          origin(character, anatomy.spine[k - 1]),
                                                          origin(character, anatomy.spine[k])));
  return nearest;
}

bool has_clavicle(const skin::Character& character, const skin::Anatomy& anatomy,
                  const std::vector<int>& arm) {
  return arm.size() > 2 && distance_to_spine(character, anatomy, arm.front()) <
                               kClavicleShare * distance_to_spine(character, anatomy, arm.back());
}

bool runs_on(const skin::Character& character, const skin::Anatomy& anatomy,
             const std::vector<int>& leg) {
  const glm::dvec3 spine = origin(character, anatomy.spine[anatomy.chest_index]) -
                           origin(character, anatomy.spine.front());
  const glm::dvec3 along = origin(character, leg.back()) - origin(character, leg.front());
  return std::abs(glm::dot(spine, along)) > kAlong * glm::length(spine) * glm::length(along);
}

/// Nodes at or below the marked ones, but for those of `own` and what hangs from them: where a body
/// is built from its head, all of it stands below. Parents stand before their children.
void mark_below(const skin::Character& character, std::vector<char>& marked,
                std::span<const int> own = {}) {
  std::vector<char> is_own(marked.size(), 0);
  for (const int node : own) is_own[static_cast<std::size_t>(node)] = 1;
  for (std::size_t n = 0; n < marked.size(); ++n) {
    const int parent = character.nodes[n].parent;
    if (parent >= 0 && marked[static_cast<std::size_t>(parent)] && !is_own[n]) marked[n] = 1;
  }
}

double weight_of(const skin::Character& character, std::size_t vertex,
                 const std::vector<char>& marked) {
  const skin::Influences& influences = character.influences[vertex];
  double sum = 0.0;
  for (int k = 0; k < skin::kMaxInfluences; ++k)
    if (marked[static_cast<std::size_t>(character.joints[influences.joint[k]].node)])
      sum += influences.weight[k];
  return sum;
}

/// A limb that is cut off: outward of the plane through its first joint, and wherever its further
/// joints move the surface.
struct Limb {
  std::vector<char> whole, beyond;  // nodes
  glm::dvec3 cut{0.0}, outward{0.0};

  Limb(const skin::Character& character, const std::vector<int>& chain, std::size_t first)
      : whole(character.nodes.size(), 0), beyond(character.nodes.size(), 0) {
    whole[static_cast<std::size_t>(chain[first])] = 1;
    mark_below(character, whole);
    if (first + 1 < chain.size()) beyond[static_cast<std::size_t>(chain[first + 1])] = 1;
    mark_below(character, beyond);
    cut = origin(character, chain[first]);
    outward = origin(character, chain.back()) - cut;
  }
};

/// Removes connected pieces that limbs move as a whole: a shoulder pad belongs to the arm, even the
/// part of it inward of the arm's first joint. `of_limb`: of each vertex, whether a limb moves it
/// by more than half.
void take_off_pieces_of_limbs(const skin::Character& character, const std::vector<char>& of_limb,
                              std::vector<std::uint8_t>& torso) {
  const std::vector<std::uint32_t> piece =
      connected_pieces(character.triangles, character.place, character.place_count);
  enum : char { no_surface, a_limbs, another_s };
  std::vector<char> moved_by(character.place_count, no_surface);  // of each piece, at its name
  for (const glm::uvec3& t : character.triangles)
    for (int i = 0; i < 3; ++i) {
      char& whose = moved_by[piece[character.place[t[i]]]];
      whose = of_limb[t[i]] && whose != another_s ? a_limbs : another_s;
    }
  for (std::size_t v = 0; v < torso.size(); ++v)
    if (moved_by[piece[character.place[v]]] == a_limbs) torso[v] = 0;
}

}  // namespace

std::vector<std::uint8_t> torso_mask(const skin::Character& character, const skin::Anatomy& anatomy,
                                     std::span<const glm::vec3> rest_position) {
  std::vector<Limb> limbs;
  for (const std::vector<int>* arm : {&anatomy.left_arm, &anatomy.right_arm})
    if (!arm->empty())
      limbs.emplace_back(character, *arm, has_clavicle(character, anatomy, *arm) ? 1 : 0);
  for (const std::vector<int>* leg : {&anatomy.left_leg, &anatomy.right_leg})
    if (!leg->empty() && !runs_on(character, anatomy, *leg))
      limbs.emplace_back(character, *leg, leg->size() > 2 ? 1 : 0);

  std::vector<char> off(character.nodes.size(), 0);
  if (anatomy.head >= 0) off[static_cast<std::size_t>(anatomy.head)] = 1;
  if (!anatomy.tail.empty()) off[static_cast<std::size_t>(anatomy.tail.front())] = 1;
  for (const skin::Follower& follower : anatomy.followers)  // feet, jaws: never of the torso
    off[static_cast<std::size_t>(follower.node)] = 1;
  mark_below(character, off, anatomy.spine);

  std::vector<std::uint8_t> torso;
  std::vector<char> of_limb;
  torso.reserve(character.vertex_count());
  for (std::size_t v = 0; v < character.vertex_count(); ++v) {
    const glm::dvec3 p(rest_position[v]);
    bool held = false, beyond = false;
    for (const Limb& limb : limbs) {
      const bool whole = weight_of(character, v, limb.whole) > 0.5;
      held |= whole;
      beyond |= weight_of(character, v, limb.beyond) > 0.5 ||
                (whole && glm::dot(p - limb.cut, limb.outward) > 0.0);
    }
    torso.push_back(weight_of(character, v, off) <= 0.5 && !beyond);
    of_limb.push_back(held);
  }
  take_off_pieces_of_limbs(character, of_limb, torso);
  return torso;
}

std::vector<float> spine_shares(const skin::Character& character, const skin::Anatomy& anatomy) {
  std::vector<char> limb(character.nodes.size(), 0);
  for (const std::vector<int>* chain :
       {&anatomy.left_arm, &anatomy.right_arm, &anatomy.left_leg, &anatomy.right_leg})
    if (!chain->empty()) limb[static_cast<std::size_t>(chain->front())] = 1;
  mark_below(character, limb);
  std::vector<float> share;
  share.reserve(character.vertex_count());
  for (std::size_t v = 0; v < character.vertex_count(); ++v)
    share.push_back(static_cast<float>(std::clamp(1.0 - weight_of(character, v, limb), 0.0, 1.0)));
  return share;
}

}  // namespace backbend::validate
