#include "skin/weights/plates.h"

#include <algorithm>
#include <cstdint>
#include <map>
#include <set>
#include <span>
#include <vector>

#include "skin/deform/skinning.h"
#include "skin/weights/weight_graph.h"

namespace backbend::skin {
namespace {

constexpr std::uint32_t kNone = 0xffffffff;
constexpr std::size_t kFewestJoints = 8;    // that move a plate alone
constexpr std::size_t kFewestVertices = 6;  // of a plate: eyes and buttons are none
constexpr double kOnlyJoint = 0.99;         // of its weight: a plate's joint moves nothing else

/// Of each node of the graph: the number of its piece.
std::vector<std::uint32_t> pieces_of(const WeightGraph& graph) {
  std::vector<std::uint32_t> piece(graph.node_count(), kNone), next;
  std::uint32_t pieces = 0;
  for (std::uint32_t start = 0; start < piece.size(); ++start) {
    if (piece[start] != kNone) continue;
    piece[start] = pieces;
    next.assign(1, start);
    while (!next.empty()) {
      const std::uint32_t at = next.back();
      next.pop_back();
      for (const std::uint32_t to : graph.neighbours(at)) {
        if (piece[to] != kNone) continue;
        piece[to] = pieces;
        next.push_back(to);
      }
    }
    ++pieces;
  }
  return piece;
}

}  // namespace

bool is_built_of_plates(const Character& character, const Anatomy& anatomy) {
  const WeightGraph graph = weight_graph(character, rest_mesh(character).position);
  struct Plate {
    std::size_t vertices = 0;
    bool is_rigid = true;  // moved by one joint alone
    JointShares weight;
  };
  std::map<std::uint32_t, Plate> plates;
  const std::vector<std::uint32_t> piece = pieces_of(graph);
  for (std::size_t n = 0; n < piece.size(); ++n) {
    const Influences& influences = character.influences[graph.vertex[n]];
    Plate& own = plates[piece[n]];
    ++own.vertices;
    for (const auto& [joint, share] : shares_of(influences)) own.weight[joint] += share;
    own.is_rigid = own.is_rigid && influences.weight[0] >= kOnlyJoint;
  }
  std::set<std::uint16_t> leading, alone;
  for (const auto& [number, own] : plates) {
    if (own.vertices < kFewestVertices || own.weight.empty()) continue;
    const auto& [joint, weight] =
        *std::ranges::max_element(own.weight, {}, [](const auto& each) { return each.second; });
    leading.insert(joint);
    if (own.is_rigid && weight >= kOnlyJoint * static_cast<double>(own.vertices))
      alone.insert(joint);
  }
  const auto torso = std::span(anatomy.spine).first(anatomy.chest_index + 1);
  const bool vertebra = std::ranges::any_of(alone, [&](std::uint16_t joint) {
    return std::ranges::find(torso, character.joints[joint].node) != torso.end();
  });
  return vertebra && alone.size() >= kFewestJoints && 2 * alone.size() >= leading.size();
}

}  // namespace backbend::skin
