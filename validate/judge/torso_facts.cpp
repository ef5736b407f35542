#include "validate/judge/torso_facts.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <vector>

#include "skin/anatomy/chain_arc.h"
#include "validate/metrics/surface/connected_pieces.h"

namespace backbend::validate {

double longest_bone(const Stage& stage) {
  const skin::Anatomy& anatomy = stage.anatomy();
  double longest = 0.0, whole = 0.0;
  for (std::size_t k = 0; k < anatomy.chest_index; ++k) {
    const auto joint = [&](std::size_t i) {
      return glm::dvec3(
          stage.character().nodes[static_cast<std::size_t>(anatomy.spine[i])].world_from_node[3]);
    };
    const double length = glm::distance(joint(k), joint(k + 1));
    longest = std::max(longest, length);
    whole += length;
  }
  return whole > 0.0 ? longest / whole : 0.0;
}

namespace {

/// The torso's surface along the spine up to the chest.
struct TorsoPlaces {
  static constexpr double kElsewhere = -1.0;
  double length = 0.0;        // of the spine
  std::size_t bones = 0;      // of it
  std::vector<double> along;  // of each vertex, an arc length; kElsewhere off the torso

  explicit TorsoPlaces(const Stage& stage) {
    const skin::Character& character = stage.character();
    const skin::Anatomy& anatomy = stage.anatomy();
    std::vector<bool> on_torso(character.nodes.size(), false);
    std::vector<glm::dvec3> chain;
    for (std::size_t k = 0; k <= anatomy.chest_index; ++k) {
      const auto node = static_cast<std::size_t>(anatomy.spine[k]);
      on_torso[node] = true;
      chain.emplace_back(character.nodes[node].world_from_node[3]);
    }
    length = skin::arc_length(chain);
    bones = chain.size() - 1;
    along.assign(character.vertex_count(), kElsewhere);
    for (std::size_t v = 0; v < along.size(); ++v) {
      const skin::Influences& influences = character.influences[v];
      double sum = 0.0;
      for (std::size_t k = 0; k < skin::kMaxInfluences && influences.weight[k] > 0.0f; ++k)
        if (on_torso[static_cast<std::size_t>(character.joints[influences.joint[k]].node)])
          sum += influences.weight[k];
      if (sum > 0.5) along[v] = skin::nearest_arc(chain, stage.rest().position[v]);
    }
  }
};

/// Whether no surface of one piece reaches along most of the torso: plates that lie over each
/// other.
bool is_plated(const Stage& stage) {
  constexpr double kMost = 0.6;
  const skin::Character& character = stage.character();
  const TorsoPlaces torso(stage);
  const std::vector<std::uint32_t> piece =
      connected_pieces(character.triangles, character.place, character.place_count);
  std::map<std::uint32_t, std::pair<double, double>> reach;
  for (std::size_t v = 0; v < torso.along.size(); ++v) {
    const double at = torso.along[v];
    if (at == TorsoPlaces::kElsewhere) continue;
    const auto known = reach.emplace(piece[character.place[v]], std::pair(at, at)).first;
    known->second = {std::min(known->second.first, at), std::max(known->second.second, at)};
  }
  return !reach.empty() && std::ranges::none_of(reach, [&](const auto& each) {
    return each.second.second - each.second.first > kMost * torso.length;
  });
}

}  // namespace

double rows_per_bone(const Stage& stage) {
  const skin::Character& character = stage.character();
  const TorsoPlaces torso(stage);
  const std::vector<double>& along = torso.along;
  std::vector<double> edges;
  for (const glm::uvec3& t : character.triangles)
    for (int i = 0; i < 3; ++i) {
      const std::size_t a = t[i], b = t[(i + 1) % 3];
      if (along[a] == TorsoPlaces::kElsewhere || along[b] == TorsoPlaces::kElsewhere) continue;
      const double length =
          glm::distance(glm::dvec3(stage.rest().position[a]), glm::dvec3(stage.rest().position[b]));
      if (std::abs(along[a] - along[b]) > 0.7 * length) edges.push_back(length);
    }
  if (edges.empty()) return 0.0;
  const auto middle = edges.begin() + static_cast<std::ptrdiff_t>(edges.size() / 2);
  std::nth_element(edges.begin(), middle, edges.end());
  return torso.length / static_cast<double>(torso.bones) / *middle;
}

bool torso_in_pieces(const Stage& stage) {
  if (is_plated(stage)) return true;
  const skin::Character& character = stage.character();
  const skin::Anatomy& anatomy = stage.anatomy();
  // How far up the spine each node hangs: legs below everything, arms, neck and head above.
  std::vector<std::size_t> level(character.nodes.size(), 0);
  for (std::size_t n = 0; n < level.size(); ++n)
    for (int node = static_cast<int>(n); node >= 0;
         node = character.nodes[static_cast<std::size_t>(node)].parent)
      if (const auto at = std::ranges::find(anatomy.spine, node); at != anatomy.spine.end()) {
        level[n] =
            std::min(static_cast<std::size_t>(at - anatomy.spine.begin()), anatomy.chest_index);
        break;
      }
  for (std::size_t k = 1; k <= anatomy.chest_index; ++k) {
    std::vector<bool> above(character.vertex_count());
    std::vector<double> weight(2, 0.0);  // that hangs from the joint below and from this one
    for (std::size_t v = 0; v < above.size(); ++v) {
      const skin::Influences& influences = character.influences[v];
      double share = 0.0;
      for (std::size_t i = 0; i < skin::kMaxInfluences && influences.weight[i] > 0.0f; ++i) {
        const auto node = static_cast<std::size_t>(character.joints[influences.joint[i]].node);
        if (level[node] >= k) share += influences.weight[i];
        if (anatomy.spine[k - 1] == static_cast<int>(node)) weight[0] += influences.weight[i];
        if (anatomy.spine[k] == static_cast<int>(node)) weight[1] += influences.weight[i];
      }
      above[v] = share >= 0.5;
    }
    if (!(weight[0] > 0.0) || !(weight[1] > 0.0)) continue;
    // Vertices at one place are one: seams of texture part no surface.
    std::vector<bool> place_above(character.place_count, false);
    for (std::size_t v = above.size(); v-- > 0;) place_above[character.place[v]] = above[v];
    const bool crossed = std::ranges::any_of(character.triangles, [&](const glm::uvec3& t) {
      const bool first = place_above[character.place[t.x]];
      return place_above[character.place[t.y]] != first ||
             place_above[character.place[t.z]] != first;
    });
    if (!crossed) return true;
  }
  return false;
}

}  // namespace backbend::validate
