#include "skin/weights/weight_borders.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <utility>

#include "skin/character/matrix_facts.h"
#include "skin/deform/skinning.h"
#include "skin/weights/plates.h"

namespace backbend::skin {
namespace {

using Index = std::size_t;

constexpr double kBoth = 0.3;         // of a vertex's weight, on the two joints together
constexpr double kAlone = 0.02;       // of the two weights: less is none
constexpr double kSoft = 0.25;        // of a border's edges, at most, where weights blend
constexpr Index kFewestEdges = 8;     // across a border, for it to be asked
constexpr double kLeastLength = 1.6;  // of the edges that cross: else no edge can hold a blend
constexpr Index kFewestOthers = 2;    // soft borders elsewhere
constexpr double kFewestLed = 1.0;    // weight of a joint, in vertices, to have a border

/// Where the weights of two joints meet.
struct Border {
  int lower = -1, upper = -1;  // nodes
  bool on_torso = false;       // both up to the chest
  Index edges = 0, hard = 0;
  double edge_length = 0.0;             // sum, of those that cross
  std::vector<std::uint32_t> vertices;  // the ends of hard edges
  double bone = 0.0;                    // between the two joints
  double hardness() const {
    return edges == 0 ? 0.0 : static_cast<double>(hard) / static_cast<double>(edges);
  }
};

double weight_on(const Character& character, std::uint32_t vertex, int node) {
  const Influences& influences = character.influences[vertex];
  double sum = 0.0;
  for (Index k = 0; k < kMaxInfluences && influences.weight[k] > 0.0f; ++k)
    if (character.joints[influences.joint[k]].node == node) sum += influences.weight[k];
  return sum;
}

/// Edges between places, each by the first vertex of its places, once.
std::vector<std::pair<std::uint32_t, std::uint32_t>> edges_of(const Character& character) {
  std::vector<std::uint32_t> vertex(character.place_count, 0);
  for (Index v = character.vertex_count(); v-- > 0;)
    vertex[character.place[v]] = static_cast<std::uint32_t>(v);
  std::vector<std::pair<std::uint32_t, std::uint32_t>> out;
  for (const glm::uvec3& t : character.triangles)
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t a = vertex[character.place[t[k]]];
      const std::uint32_t b = vertex[character.place[t[(k + 1) % 3]]];
      if (a != b) out.emplace_back(std::min(a, b), std::max(a, b));
    }
  std::sort(out.begin(), out.end());
  out.erase(std::unique(out.begin(), out.end()), out.end());
  return out;
}

/// The borders between neighbouring joints of the spine, hips to head, that have weight.
std::vector<Border> borders_of(const Character& character, const Anatomy& anatomy) {
  std::vector<double> total(character.nodes.size(), 0.0);
  for (Index v = 0; v < character.vertex_count(); ++v)
    for (Index k = 0; k < kMaxInfluences && character.influences[v].weight[k] > 0.0f; ++k)
      total[static_cast<Index>(character.joints[character.influences[v].joint[k]].node)] +=
          character.influences[v].weight[k];
  std::vector<Border> out;
  int below = -1;
  for (Index k = 0; k < anatomy.spine.size(); ++k) {
    const int node = anatomy.spine[k];
    if (!(total[static_cast<Index>(node)] > kFewestLed)) continue;
    if (below >= 0) {
      Border border;
      border.lower = below;
      border.upper = node;
      border.on_torso = k <= anatomy.chest_index;
      border.bone =
          glm::distance(origin(character.nodes[static_cast<Index>(below)].world_from_node),
                        origin(character.nodes[static_cast<Index>(node)].world_from_node));
      out.push_back(std::move(border));
    }
    below = node;
  }
  return out;
}

/// The upper joint's share of both joints' weights at a vertex; below 0 where they are not what
/// moves it.
double upper_share(const Character& character, const Border& border, std::uint32_t vertex) {
  const double low = weight_on(character, vertex, border.lower);
  const double high = weight_on(character, vertex, border.upper);
  return low + high < kBoth ? -1.0 : high / (low + high);
}

void count_edges(const Character& character, const std::vector<glm::vec3>& point,
                 const std::vector<std::pair<std::uint32_t, std::uint32_t>>& edges,
                 Border& border) {
  std::vector<double> share(character.vertex_count());
  for (Index v = 0; v < share.size(); ++v)
    share[v] = upper_share(character, border, static_cast<std::uint32_t>(v));
  const auto alone = [](double t) { return std::min(t, 1.0 - t) < kAlone; };
  for (const auto& [a, b] : edges) {
    if (share[a] < 0.0 || share[b] < 0.0 || (share[a] < 0.5) == (share[b] < 0.5)) continue;
    ++border.edges;
    border.edge_length += glm::distance(point[a], point[b]);
    if (!alone(share[a]) || !alone(share[b])) continue;
    ++border.hard;
    border.vertices.push_back(a);
    border.vertices.push_back(b);
  }
  std::sort(border.vertices.begin(), border.vertices.end());
  border.vertices.erase(std::unique(border.vertices.begin(), border.vertices.end()),
                        border.vertices.end());
}

}  // namespace

WeightAnswer find_hard_borders(const Character& character, const Anatomy& anatomy) {
  WeightAnswer out;
  const auto edges = edges_of(character);
  std::vector<Border> borders = borders_of(character, anatomy);
  const PosedMesh rest = rest_mesh(character);
  for (Border& border : borders) count_edges(character, rest.position, edges, border);
  std::erase_if(borders, [](const Border& border) {
    return border.edges < kFewestEdges ||
           border.bone * static_cast<double>(border.edges) < kLeastLength * border.edge_length;
  });
  const auto soft = static_cast<Index>(std::ranges::count_if(
      borders, [](const Border& border) { return border.hardness() <= kSoft; }));
  if (soft < kFewestOthers || 2 * soft <= borders.size()) {
    out.not_applicable = "of " + std::to_string(borders.size()) +
                         " borders between joints of the spine " + std::to_string(soft) +
                         " are soft, " + std::to_string(kFewestOthers) + " and most are needed";
    return out;
  }
  for (Border& border : borders) {
    if (!border.on_torso || border.hardness() <= kSoft) continue;
    WeightFault fault;
    fault.node = border.lower;
    fault.other = border.upper;
    fault.value = border.hardness();
    fault.vertex = border.vertices.front();
    fault.places = border.vertices.size();
    fault.vertices = std::move(border.vertices);
    out.faults.push_back(std::move(fault));
  }
  if (!out.faults.empty() && is_built_of_plates(character, anatomy)) {
    out.faults.clear();
    out.not_applicable = kPlatesPart;
    return out;
  }
  std::ranges::stable_sort(
      out.faults, [](const WeightFault& a, const WeightFault& b) { return a.value > b.value; });
  return out;
}

}  // namespace backbend::skin
