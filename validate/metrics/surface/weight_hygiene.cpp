#include "validate/metrics/surface/weight_hygiene.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <optional>

#include "skin/character/ancestor.h"
#include "skin/character/closest_point.h"
#include "skin/character/matrix_facts.h"
#include "skin/character/part_owners.h"
#include "skin/deform/skinning.h"
#include "validate/metrics/math/median.h"

namespace backbend::validate {
namespace {

constexpr double kStrayWeight = 0.505;  // half, and what stored weights round
// A tiny weight does not count as membership: rounding to 8 bits leaves many.
constexpr float kTrace = 0.004f;  // one step of 8 bits

bool knows(const skin::Influences& influences, std::uint16_t joint) {
  for (int k = 0; k < skin::kMaxInfluences; ++k)
    if (influences.joint[k] == joint && influences.weight[k] > kTrace) return true;
  return false;
}

constexpr double kTipWeight = 1.5;  // in vertices: of a joint, beside the vertex at its tip
constexpr int kRelated = 2;         // joints along a limb that may share a finger's tip

/// Whether one joint hangs from the other by at most kRelated bones.
bool related(std::span<const int> parent, std::uint16_t a, std::uint16_t b) {
  const auto hangs = [&](int low, int high) {
    for (int k = 0; k <= kRelated && low >= 0; ++k, low = parent[static_cast<std::size_t>(low)])
      if (low == high) return true;
    return false;
  };
  return hangs(a, b) || hangs(b, a);
}

bool knows_a_relative(const skin::Influences& influences, std::uint16_t joint,
                      std::span<const int> parent) {
  for (int k = 0; k < skin::kMaxInfluences; ++k)
    if (influences.weight[k] > kTrace && related(parent, influences.joint[k], joint)) return true;
  return false;
}

bool share_a_joint(const skin::Influences& a, const skin::Influences& b) {
  for (int k = 0; k < skin::kMaxInfluences; ++k)
    if (a.weight[k] > kTrace && knows(b, a.joint[k])) return true;
  return false;
}

/// Pairs of neighbouring places, both ways, sorted.
using Pairs = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

Pairs neighbour_pairs(std::span<const glm::uvec3> triangle, std::span<const std::uint32_t> place) {
  Pairs pairs;
  pairs.reserve(triangle.size() * 6);
  for (const glm::uvec3& t : triangle)
    for (int i = 0; i < 3; ++i) {
      const std::uint32_t a = place[t[i]], b = place[t[(i + 1) % 3]];
      if (a == b) continue;
      pairs.emplace_back(a, b);
      pairs.emplace_back(b, a);
    }
  std::ranges::sort(pairs);
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  return pairs;
}

/// Whether the neighbours' neighbours know nothing of a vertex's joints either: where the vertices
/// around it do not agree among themselves, one ring is too small to tell.
bool unknown_further(const Pairs& pairs, std::size_t first, std::size_t end,
                     std::span<const skin::Influences> influences,
                     const std::vector<std::uint32_t>& vertex_of_place, std::uint32_t vertex) {
  const std::uint32_t place = pairs[first].first;
  for (std::size_t i = first; i < end; ++i) {
    auto next = std::ranges::lower_bound(pairs, std::pair(pairs[i].second, std::uint32_t{0}));
    for (; next != pairs.end() && next->first == pairs[i].second; ++next)
      if (next->second != place &&
          share_a_joint(influences[vertex], influences[vertex_of_place[next->second]]))
        return false;
  }
  return true;
}

/// Whether a mesh is too coarse at a vertex for its neighbours to tell what it should follow.
using TooCoarse =
    std::function<bool(std::uint32_t vertex, std::span<const std::uint32_t> neighbours)>;

WeightHygiene examine(std::span<const skin::Influences> influences,
                      std::span<const glm::uvec3> triangle, std::span<const std::uint32_t> place,
                      std::uint32_t place_count, std::span<const int> parent,
                      const TooCoarse& is_too_coarse) {
  WeightHygiene out;
  std::vector<std::uint32_t> vertex_of_place(place_count, 0);
  for (std::size_t v = influences.size(); v-- > 0;) {
    vertex_of_place[place[v]] = static_cast<std::uint32_t>(v);
    double sum = 0.0;
    for (float w : influences[v].weight) sum += w;
    if (!(sum > 0.0)) {  // NaN counts as none
      ++out.unweighted;
      out.unweighted_vertex = static_cast<int>(v);
      continue;
    }
    if (!(std::abs(sum - 1.0) <= out.worst_sum)) {
      out.worst_sum = std::abs(sum - 1.0);
      out.worst_sum_vertex = static_cast<int>(v);
    }
  }

  const auto pairs = neighbour_pairs(triangle, place);
  std::vector<double> total;  // weight of each joint, by place
  for (const std::uint32_t v : vertex_of_place)
    for (int k = 0; k < skin::kMaxInfluences; ++k)
      if (influences[v].weight[k] > kTrace) {
        total.resize(std::max<std::size_t>(total.size(), influences[v].joint[k] + std::size_t{1}));
        total[influences[v].joint[k]] += influences[v].weight[k];
      }
  for (std::size_t first = 0; first < pairs.size();) {
    std::size_t end = first;
    while (end < pairs.size() && pairs[end].first == pairs[first].first) ++end;
    const std::uint32_t vertex = vertex_of_place[pairs[first].first];
    const auto neighbour = [&](std::size_t i) -> const skin::Influences& {
      return influences[vertex_of_place[pairs[i].second]];
    };
    double foreign = 0.0;
    for (int k = 0; k < skin::kMaxInfluences; ++k) {
      const float weight = influences[vertex].weight[k];
      if (!(weight > kTrace)) continue;
      // The joint moves little else.
      const bool is_tip =
          !parent.empty() && total[influences[vertex].joint[k]] - weight < kTipWeight;
      bool known = false;
      for (std::size_t i = first; i < end && !known; ++i)
        known = is_tip ? knows_a_relative(neighbour(i), influences[vertex].joint[k], parent)
                       : knows(neighbour(i), influences[vertex].joint[k]);
      if (!known) foreign += weight;
    }
    if (foreign > kStrayWeight && end - first > 1) {
      bool agree = true;
      for (std::size_t i = first; i < end && agree; ++i)
        for (std::size_t j = i + 1; j < end && agree; ++j)
          agree = share_a_joint(neighbour(i), neighbour(j));
      std::vector<std::uint32_t> around;
      for (std::size_t i = first; i < end; ++i) around.push_back(vertex_of_place[pairs[i].second]);
      if ((agree || unknown_further(pairs, first, end, influences, vertex_of_place, vertex)) &&
          !is_too_coarse(vertex, around)) {
        ++out.stray;
        out.strays.push_back(vertex);
        if (foreign > out.stray_weight) {
          out.stray_weight = foreign;
          out.stray_vertex = static_cast<int>(vertex);
        }
      }
    }
    first = end;
  }
  return out;
}

}  // namespace

WeightHygiene examine_weights(std::span<const skin::Influences> influences,
                              std::span<const glm::uvec3> triangle,
                              std::span<const std::uint32_t> place, std::uint32_t place_count,
                              std::span<const int> parent) {
  return examine(influences, triangle, place, place_count, parent,
                 [](std::uint32_t, std::span<const std::uint32_t>) { return false; });
}

WeightHygiene examine_weights(const skin::Character& character,
                              std::span<const skin::Influences> influences, int head) {
  std::vector<int> joint_of_node(character.nodes.size(), -1);
  for (std::size_t j = 0; j < character.joints.size(); ++j)
    joint_of_node[static_cast<std::size_t>(character.joints[j].node)] = static_cast<int>(j);
  std::vector<int> parent;
  for (const skin::SkinJoint& joint : character.joints) {
    int node = character.nodes[static_cast<std::size_t>(joint.node)].parent;
    while (node >= 0 && joint_of_node[static_cast<std::size_t>(node)] < 0)
      node = character.nodes[static_cast<std::size_t>(node)].parent;
    parent.push_back(node < 0 ? -1 : joint_of_node[static_cast<std::size_t>(node)]);
  }
  const auto on_head = [&](int node) { return skin::is_ancestor(character, head, node); };
  std::vector<std::uint16_t> stands_for;  // of each joint
  std::optional<std::uint16_t> first_on_head;
  for (std::size_t j = 0; j < character.joints.size(); ++j) {
    const auto own = static_cast<std::uint16_t>(j);
    const bool is_on_head = head >= 0 && on_head(character.joints[j].node);
    if (is_on_head && !first_on_head) first_on_head = own;
    stands_for.push_back(is_on_head ? *first_on_head : own);
  }
  std::vector<skin::Influences> known(influences.begin(), influences.end());
  if (first_on_head)
    for (skin::Influences& each : known)
      for (std::uint16_t& joint : each.joint) joint = stands_for[joint];
  const std::vector<bool> is_prop = skin::nodes_of_props(character);  // no bone leads to its pivot
  const auto distance_to_bones = [&](std::size_t joint, const glm::dvec3& point) {
    const auto place = [&](std::size_t j) {
      return skin::origin(
          character.nodes[static_cast<std::size_t>(character.joints[j].node)].world_from_node);
    };
    double nearest = glm::distance(point, place(joint));
    for (std::size_t j = 0; j < parent.size(); ++j)
      if (parent[j] == static_cast<int>(joint) &&
          !is_prop[static_cast<std::size_t>(character.joints[j].node)])
        nearest = std::min(nearest, skin::distance_to_segment(point, place(joint), place(j)));
    return nearest;
  };
  std::optional<skin::PosedMesh> rest;
  const auto is_too_coarse = [&](std::uint32_t vertex, std::span<const std::uint32_t> around) {
    if (!rest) rest = skin::rest_mesh(character);
    const glm::dvec3 point(rest->position[vertex]);
    std::vector<double> edge;
    for (const std::uint32_t other : around)
      edge.push_back(glm::distance(point, glm::dvec3(rest->position[other])));
    return distance_to_bones(influences[vertex].joint[0], point) < median(std::move(edge));
  };
  return examine(known, character.triangles, character.place, character.place_count, parent,
                 is_too_coarse);
}

}  // namespace backbend::validate
