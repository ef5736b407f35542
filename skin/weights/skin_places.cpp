#include "skin/weights/skin_places.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <map>
#include <numeric>

#include "skin/anatomy/chain_arc.h"
#include "skin/anatomy/other_figures.h"
#include "skin/character/matrix_facts.h"
#include "skin/character/point_cells.h"
#include "skin/deform/skinning.h"

namespace backbend::skin {
namespace {

using Index = std::size_t;

// Lengths are shares of the body's largest side.
constexpr double kShellGap = 0.03;  // from one shell to another that it lies on
constexpr double kOneStand = 1e-5;  // between joints that stand in one place
constexpr double kFarSpine = 0.4;   // of the spine's length, where its joints stand densely
constexpr Index kFewestOfCostume = 6;
constexpr double kAlike = 0.01;  // of a place's weight, between places of one piece of costume
constexpr double kMostCostume = 0.95;  // of the vertebrae's weight: else the body is of pieces

}  // namespace

PlaceWeights weights_of(const Character& character, Index vertex) {
  PlaceWeights out;
  const Influences& influences = character.influences[vertex];
  for (Index k = 0; k < kMaxInfluences && influences.weight[k] > 0.0f; ++k) {
    const int node = character.joints[influences.joint[k]].node;
    const auto known =
        std::find_if(out.begin(), out.end(), [&](const NodeWeight& w) { return w.node == node; });
    if (known == out.end())
      out.push_back({node, influences.weight[k]});
    else
      known->weight += influences.weight[k];
  }
  return out;
}

WeightDifference weight_difference(const PlaceWeights& a, const PlaceWeights& b,
                                   const std::vector<int>* image) {
  std::map<int, double> sum;
  for (const NodeWeight& w : a)
    sum[image ? (*image)[static_cast<Index>(w.node)] : w.node] -= w.weight;
  for (const NodeWeight& w : b) sum[w.node] += w.weight;
  WeightDifference out;
  double high = 0.0, low = 0.0;
  for (const auto& [node, weight] : sum) {
    out.share += 0.5 * std::abs(weight);
    if (weight > high) {
      high = weight;
      out.most = node;
    }
    if (weight < low) {
      low = weight;
      out.least = node;
    }
  }
  return out;
}

PlaceNeighbours::PlaceNeighbours(const std::vector<std::pair<Index, Index>>& pairs, Index places)
    : first(places + 1, 0), of(pairs.size()) {
  for (const auto& [a, b] : pairs) ++first[a + 1];
  for (Index p = 0; p < places; ++p) first[p + 1] += first[p];
  std::vector<Index> next(first.begin(), first.end() - 1);
  for (const auto& [a, b] : pairs) of[next[a]++] = b;
  for (Index p = 0; p < places; ++p)
    std::sort(of.begin() + static_cast<std::ptrdiff_t>(first[p]),
              of.begin() + static_cast<std::ptrdiff_t>(first[p + 1]));
}

SkinPlaces::SkinPlaces(const Character& character, const Anatomy& anatomy)
    : character_(character), anatomy_(anatomy) {
  std::vector<bool> unweighted(character.vertex_count(), false);
  for (const std::uint32_t v : character.unweighted) unweighted[v] = true;
  const std::vector<bool> is_other = vertices_of_other_figures(character, anatomy);
  vertex.assign(character.place_count, 0);
  weights.resize(character.place_count);
  for (Index v = character.vertex_count(); v-- > 0;)
    vertex[character.place[v]] = static_cast<std::uint32_t>(v);
  const PosedMesh rest = rest_mesh(character);
  for (const std::uint32_t v : vertex) point.emplace_back(rest.position[v]);
  for (Index p = 0; p < weights.size(); ++p)
    if (!unweighted[vertex[p]] && !is_other[vertex[p]])
      weights[p] = weights_of(character, vertex[p]);
  for (const Node& node : character.nodes) parent.push_back(node.parent);
  for (const Follower& one : anatomy.followers) parent[static_cast<Index>(one.node)] = one.leader;
  main.assign(weights.size(), -1);
  total.assign(character.nodes.size(), 0.0);
  for (Index p = 0; p < weights.size(); ++p) {
    double most = 0.0;
    for (const NodeWeight& w : weights[p]) {
      total[static_cast<Index>(w.node)] += w.weight;
      if (w.weight > most) {
        most = w.weight;
        main[p] = w.node;
      }
    }
  }
  glm::dvec3 low(std::numeric_limits<double>::infinity()), high = -low;
  for (Index p = 0; p < point.size(); ++p) {
    if (is_other[vertex[p]]) continue;
    ++own_count;
    low = glm::min(low, point[p]);
    high = glm::max(high, point[p]);
  }
  const glm::dvec3 sides = high - low;
  size = std::max({sides.x, sides.y, sides.z, 0.0});
  all = std::accumulate(total.begin(), total.end(), 0.0);
  find_hung_objects();
  leads_on_.assign(total.size(), false);
  for (Index n = 0; n < total.size(); ++n) {
    Index steps = 0;
    for (int above = parent[n]; total[n] > 0.0 && above >= 0 && steps < parent.size(); ++steps) {
      leads_on_[static_cast<Index>(above)] = true;
      above = parent[static_cast<Index>(above)];
    }
  }
  measure_torso();
  if (size > 0.0 && all > 0.0) list_edges();
}

glm::dvec3 SkinPlaces::at(int node) const {
  return origin(character_.nodes[static_cast<Index>(node)].world_from_node);
}

/// The chain of the spine's joints, and how far the torso's surface is from it.
void SkinPlaces::measure_torso() {
  on_spine.assign(total.size(), -1);
  for (Index k = 0; k < anatomy_.spine.size(); ++k) {
    on_spine[static_cast<Index>(anatomy_.spine[k])] = static_cast<int>(k);
    chain.push_back(at(anatomy_.spine[k]));
    arc.push_back(k == 0 ? 0.0 : arc.back() + glm::distance(chain[k - 1], chain[k]));
  }
  along.assign(weights.size(), 0.0);
  beside.assign(weights.size(), 0.0);
  double sum = 0.0, weight = 0.0;
  for (Index p = 0; p < weights.size(); ++p)
    for (const NodeWeight& w : weights[p]) {
      const int k = on_spine[static_cast<Index>(w.node)];
      if (k < 0) continue;
      if (!(beside[p] > 0.0)) {
        along[p] = nearest_arc(chain, point[p]);
        beside[p] = glm::distance(point_at(along[p]), point[p]);
      }
      if (static_cast<Index>(k) > anatomy_.chest_index) continue;
      sum += w.weight * beside[p];
      weight += w.weight;
    }
  half_width = weight > 0.0 ? sum / weight : 0.0;
  spine_step_ = std::max(kFarSpine * arc[anatomy_.chest_index], half_width) / kFarJoints;
}

glm::dvec3 SkinPlaces::point_at(double arc_length) const {
  Index k = 1;
  while (k + 1 < chain.size() && arc[k] < arc_length) ++k;
  const double step = arc[k] - arc[k - 1];
  return step > 0.0 ? glm::mix(chain[k - 1], chain[k], (arc_length - arc[k - 1]) / step) : chain[k];
}

/// Meshes without a skin, each on a node of its own below a joint, and what stands between. Written
/// as skins, as by `bake`, they are joints that alone move all of what they move, below a node that
/// is none.
void SkinPlaces::find_hung_objects() {
  const Index nodes = character_.nodes.size();
  std::vector<bool> moves(nodes, false), shares(nodes, false), is_joint(nodes, false);
  for (const Influences& influences : character_.influences)
    for (Index k = 0; k < kMaxInfluences && influences.weight[k] > 0.0f; ++k) {
      const auto n = static_cast<Index>(character_.joints[influences.joint[k]].node);
      moves[n] = true;
      if (influences.weight[1] > 0.0f) shares[n] = true;
    }
  std::vector<bool> is_bound = is_joint;  // not where the reader puts a mesh without a skin
  for (const SkinJoint& joint : character_.joints) {
    is_joint[static_cast<Index>(joint.node)] = true;
    if (joint.joint_from_mesh != glm::dmat4(1.0)) is_bound[static_cast<Index>(joint.node)] = true;
  }
  // Vertebrae and limbs may have no weight of their own, and then are in no skin.
  for (const auto* chain : {&anatomy_.spine, &anatomy_.left_arm, &anatomy_.right_arm,
                            &anatomy_.left_leg, &anatomy_.right_leg})
    for (const int node : *chain) is_joint[static_cast<Index>(node)] = true;
  std::vector<bool> leads_on(nodes, false);
  for (Index n = nodes; n-- > 0;) {  // parents stand first
    const int above = character_.nodes[n].parent;
    if (above >= 0 && (moves[n] || leads_on[n])) leads_on[static_cast<Index>(above)] = true;
  }
  hangs_.assign(nodes, false);
  for (Index n = 0; n < nodes; ++n) {
    int above = character_.nodes[n].parent;
    if (!moves[n] || shares[n] || leads_on[n] || above < 0 ||
        (is_bound[n] && is_joint[static_cast<Index>(above)]))
      continue;
    std::vector<Index> way{n};
    for (; above >= 0 && !is_joint[static_cast<Index>(above)];
         above = character_.nodes[static_cast<Index>(above)].parent)
      way.push_back(static_cast<Index>(above));
    if (above < 0) continue;
    for (const Index each : way) hangs_[each] = true;
  }
}

/// What the way from a joint to the one above it counts: nothing where they stand in one place,
/// and of a spine of many joints, where three are a short way, by its length.
double SkinPlaces::step_above(int node) const {
  const int above = parent[static_cast<Index>(node)];
  if (above < 0) return 1.0;
  if (hangs_[static_cast<Index>(node)]) return 0.0;
  if (glm::distance(at(node), at(above)) < kOneStand * size) return 0.0;
  // Where controls and joints that move the skin are two chains, each vertebra has one beside it.
  if (on_spine[static_cast<Index>(above)] >= 0 && !(total[static_cast<Index>(above)] > 0.0) &&
      total[static_cast<Index>(node)] > 0.0 && !leads_on_[static_cast<Index>(node)])
    return 0.0;
  if (on_spine[static_cast<Index>(node)] < 0 || on_spine[static_cast<Index>(above)] < 0) return 1.0;
  return std::min(1.0, glm::distance(at(node), at(above)) / spine_step_);
}

double SkinPlaces::steps_between(int a, int b) const {
  std::vector<std::pair<int, double>> up;
  double steps = 0.0;
  for (int n = a; n >= 0 && up.size() < parent.size(); n = parent[static_cast<Index>(n)]) {
    up.emplace_back(n, steps);
    steps += step_above(n);
  }
  steps = 0.0;
  Index count = 0;
  for (int n = b; n >= 0 && count < parent.size(); n = parent[static_cast<Index>(n)], ++count) {
    const auto found =
        std::find_if(up.begin(), up.end(), [&](const auto& e) { return e.first == n; });
    if (found != up.end()) return steps + found->second;
    steps += step_above(n);
  }
  return std::numeric_limits<double>::infinity();  // of another root
}

int SkinPlaces::heaviest_but(Index place, int node) const {
  int best = -1;
  double most = 0.0;
  for (const NodeWeight& w : weights[place])
    if (w.node != node && w.weight > most) {
      most = w.weight;
      best = w.node;
    }
  return best;
}

double SkinPlaces::weight_at(Index place, int node) const {
  for (const NodeWeight& w : weights[place])
    if (w.node == node) return w.weight;
  return 0.0;
}

void SkinPlaces::list_edges() {
  std::vector<std::pair<Index, Index>> pairs;
  for (const glm::uvec3& t : character_.triangles)
    for (int k = 0; k < 3; ++k) {
      const Index a = character_.place[t[k]], b = character_.place[t[(k + 1) % 3]];
      pairs.emplace_back(a, b);
      pairs.emplace_back(b, a);
    }
  edges = PlaceNeighbours(pairs, weights.size());
  find_shells();
  find_costume();
  link_shells(pairs);
  linked = PlaceNeighbours(pairs, weights.size());
}

/// The pieces of the surface that no edges join.
void SkinPlaces::find_shells() {
  const Index none = weights.size();
  shell.assign(weights.size(), none);
  std::vector<Index> pending;
  for (Index start = 0; start < shell.size(); ++start) {
    if (shell[start] != none) continue;
    shell[start] = shell_size.size();
    shell_size.push_back(0);
    pending.push_back(start);
    while (!pending.empty()) {
      const Index p = pending.back();
      pending.pop_back();
      ++shell_size.back();
      for (Index e = edges.first[p]; e < edges.first[p + 1]; ++e)
        if (shell[edges.of[e]] == none) {
          shell[edges.of[e]] = shell_size.size() - 1;
          pending.push_back(edges.of[e]);
        }
    }
  }
  std::vector<Index> moved(shell_size.size(), 0);
  for (Index p = 0; p < shell.size(); ++p) moved[shell[p]] += main[p] >= 0;
  largest_shell = static_cast<Index>(std::max_element(moved.begin(), moved.end()) - moved.begin());
}

void SkinPlaces::find_costume() {
  std::vector<Index> first(shell_size.size(), weights.size());
  for (const Index count : shell_size) costume.push_back(count >= kFewestOfCostume);
  double on_costume = 0.0, on_all = 0.0;
  for (Index p = 0; p < weights.size(); ++p) {
    Index& known = first[shell[p]];
    if (known == weights.size()) known = p;
    if (weight_difference(weights[p], weights[known], nullptr).share > kAlike)
      costume[shell[p]] = false;
  }
  for (Index p = 0; p < weights.size(); ++p)
    for (const NodeWeight& w : weights[p]) {
      const int on = on_spine[static_cast<Index>(w.node)];
      if (on < 0 || static_cast<Index>(on) > anatomy_.chest_index) continue;
      on_all += w.weight;
      if (costume[shell[p]]) on_costume += w.weight;
    }
  if (on_costume > kMostCostume * on_all) costume.assign(shell_size.size(), false);
}

/// From each place of a shell to the nearest place of another: a belt's or a tuft's weights go on
/// where the body's below them do, though no edge leads there. The largest shell's places ask
/// for none.
void SkinPlaces::link_shells(std::vector<std::pair<Index, Index>>& pairs) const {
  if (shell_size.size() < 2) return;
  const PointCells cells(point, kShellGap * size);
  for (Index p = 0; p < shell.size(); ++p) {
    if (shell[p] == largest_shell) continue;
    const Index q = cells.nearest(point[p], [&](Index i) { return shell[i] != shell[p]; });
    if (q == cells.size()) continue;
    pairs.emplace_back(p, q);
    pairs.emplace_back(q, p);
  }
}

std::vector<glm::dvec3> SkinPlaces::points_on_bones(int node) const {
  std::vector<glm::dvec3> points{at(node)};
  for (Index n = 0; n < character_.nodes.size(); ++n)
    if (character_.nodes[n].parent == node && total[n] > 0.0) {
      const glm::dvec3 end = at(static_cast<int>(n));
      for (int k = 1; k <= 4; ++k) points.push_back(glm::mix(at(node), end, 0.25 * k));
    }
  return points;
}

}  // namespace backbend::skin
