#include "skin/weight_hygiene.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <numeric>
#include <tuple>

#include "skin/joint_names.h"
#include "skin/matrix_facts.h"
#include "skin/skinning.h"

namespace backbend::skin {
namespace {

using Index = std::size_t;

constexpr double kMirrorTolerance = 0.002;  // of the height
constexpr double kAsymmetryCounts = 0.05;

/// Disjoint sets over 0..count-1; the smallest member stands for its set.
class Sets {
 public:
  explicit Sets(Index count) : parent_(count) {
    std::iota(parent_.begin(), parent_.end(), Index{0});
  }
  Index find(Index a) {
    while (parent_[a] != a) a = parent_[a] = parent_[parent_[a]];
    return a;
  }
  void join(Index a, Index b) {
    a = find(a);
    b = find(b);
    if (a != b) parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<Index> parent_;
};

int node_of(const Character& character, const Influences& influences, Index k) {
  return character.joints[influences.joint[k]].node;
}

/// The first vertex of every place.
std::vector<std::uint32_t> vertex_of_place(const Character& character) {
  std::vector<std::uint32_t> out(character.place_count);
  for (Index v = character.vertex_count(); v-- > 0;)
    out[character.place[v]] = static_cast<std::uint32_t>(v);
  return out;
}

void count_influences(const Character& character, WeightHygiene& out) {
  std::vector<bool> unweighted(character.vertex_count(), false);
  for (const std::uint32_t v : character.unweighted) unweighted[v] = true;
  for (Index v = 0; v < character.vertex_count(); ++v) {
    Index count = 0;
    for (const float weight : character.influences[v].weight) {
      count += weight > 0.0f;
      out.tiny += weight > 0.0f && weight < kTinyWeight;
    }
    ++out.with_influences[unweighted[v] ? 0 : count];
    out.more_than_four += count > 4;
  }
  out.unweighted = character.unweighted.size();
  out.off_sum = character.renormalised_vertices;
  out.worst_sum = character.worst_weight_sum;
}

void find_bleed(const Character& character, const std::vector<std::uint32_t>& vertex,
                WeightHygiene& out) {
  // One element for each (place, influence): joined where neighbours share the joint.
  Sets islands(static_cast<Index>(character.place_count) * kMaxInfluences);
  Sets shells(character.place_count);
  const auto weighs = [&](Index place, Index k) {
    return character.influences[vertex[place]].weight[k] > kTinyWeight;
  };
  for (const glm::uvec3& triangle : character.triangles)
    for (int corner = 0; corner < 3; ++corner) {
      const Index a = character.place[triangle[corner]];
      const Index b = character.place[triangle[(corner + 1) % 3]];
      shells.join(a, b);
      for (Index i = 0; i < kMaxInfluences && weighs(a, i); ++i)
        for (Index k = 0; k < kMaxInfluences && weighs(b, k); ++k)
          if (node_of(character, character.influences[vertex[a]], i) ==
              node_of(character, character.influences[vertex[b]], k))
            islands.join(a * kMaxInfluences + i, b * kMaxInfluences + k);
    }

  struct Island {
    double weight = 0.0;
    Bleed facts;
  };
  std::map<std::tuple<int, Index, Index>, Island> found;  // node, shell, island
  for (Index place = 0; place < character.place_count; ++place)
    for (Index k = 0; k < kMaxInfluences && weighs(place, k); ++k) {
      const Influences& influences = character.influences[vertex[place]];
      const int node = node_of(character, influences, k);
      Island& island = found[{node, shells.find(place), islands.find(place * kMaxInfluences + k)}];
      island.weight += influences.weight[k];
      island.facts.node = node;
      ++island.facts.places;
      if (influences.weight[k] > island.facts.largest) {
        island.facts.largest = influences.weight[k];
        island.facts.vertex = vertex[place];
      }
    }
  for (auto at = found.begin(); at != found.end();) {
    const auto same_area = [&](const auto& entry) {
      return std::get<0>(entry.first) == std::get<0>(at->first) &&
             std::get<1>(entry.first) == std::get<1>(at->first);
    };
    const auto end = std::find_if_not(at, found.end(), same_area);
    const auto main = std::max_element(
        at, end, [](const auto& a, const auto& b) { return a.second.weight < b.second.weight; });
    for (; at != end; ++at) {
      if (at == main) continue;
      const Bleed& island = at->second.facts;
      if (island.largest < kBleedCounts) continue;
      if (out.bleed.empty() || out.bleed.back().node != island.node)
        out.bleed.push_back({island.node});
      Bleed& sum = out.bleed.back();
      sum.places += island.places;
      if (island.largest > sum.largest) {
        sum.largest = island.largest;
        sum.vertex = island.vertex;
      }
    }
  }
}

/// The reflection that swaps a character's left and right.
struct Mirror {
  glm::dvec3 left, middle;
  glm::dvec3 operator()(const glm::dvec3& p) const {
    return p - 2.0 * glm::dot(p - middle, left) * left;
  }
};

/// The node on the other side of each node, itself in the middle.
std::vector<int> mirrored_nodes(const Character& character, const Mirror& mirror) {
  std::map<std::tuple<std::string, int, Side>, int> by_name;
  std::vector<NameFacts> facts;
  for (const Node& node : character.nodes) facts.push_back(read_joint_name(node.name));
  for (Index n = 0; n < facts.size(); ++n)
    if (facts[n].side != Side::none)
      by_name.emplace(
          std::tuple(facts[n].without_side, static_cast<int>(facts[n].part), facts[n].side),
          static_cast<int>(n));
  std::vector<int> out(facts.size());
  for (Index n = 0; n < facts.size(); ++n) {
    out[n] = static_cast<int>(n);
    if (facts[n].side != Side::none) {
      const Side other = facts[n].side == Side::left ? Side::right : Side::left;
      const auto found =
          by_name.find({facts[n].without_side, static_cast<int>(facts[n].part), other});
      if (found != by_name.end()) out[n] = found->second;
      continue;
    }
    // No side in the name: the nearest joint to the mirrored place, itself where that is nearest.
    const glm::dvec3 image = mirror(origin(character.nodes[n].world_from_node));
    double nearest = glm::distance(image, origin(character.nodes[n].world_from_node));
    for (const SkinJoint& joint : character.joints) {
      const auto m = static_cast<Index>(joint.node);
      if (facts[m].side != Side::none) continue;
      const double distance = glm::distance(image, origin(character.nodes[m].world_from_node));
      if (distance < 0.5 * nearest) {
        nearest = distance;
        out[n] = joint.node;
      }
    }
  }
  return out;
}

/// Half the sum of the differences between one vertex's weights and its image's, 0..1.
double difference(const Character& character, const std::vector<int>& other, Index a, Index b) {
  std::map<int, double> sum;
  for (Index k = 0; k < kMaxInfluences; ++k) {
    const Influences& here = character.influences[a];
    const Influences& there = character.influences[b];
    if (here.weight[k] > 0.0f)
      sum[other[static_cast<Index>(node_of(character, here, k))]] += here.weight[k];
    if (there.weight[k] > 0.0f) sum[node_of(character, there, k)] -= there.weight[k];
  }
  double total = 0.0;
  for (const auto& [node, weight] : sum) total += std::abs(weight);
  return 0.5 * total;
}

/// Places in cells of one edge length, to find the nearest to a point.
class Cells {
 public:
  Cells(std::vector<glm::dvec3> points, double edge) : points_(std::move(points)), edge_(edge) {
    for (Index p = 0; p < points_.size(); ++p)
      if (has_cell(points_[p])) cells_.push_back({key(points_[p]), p});
    std::sort(cells_.begin(), cells_.end());
  }
  /// The nearest point within one edge length, or points_.size().
  Index nearest(const glm::dvec3& at) const {
    Index best = points_.size();
    if (!has_cell(at)) return best;
    double least = edge_;
    const auto [x, y, z] = key(at);
    for (long dx = -1; dx <= 1; ++dx)
      for (long dy = -1; dy <= 1; ++dy) {
        // Cells are sorted by z last: three in a row are one run.
        auto cell = std::lower_bound(cells_.begin(), cells_.end(),
                                     Cell{Key{x + dx, y + dy, z - 1}, Index{0}});
        for (; cell != cells_.end() && cell->first <= Key{x + dx, y + dy, z + 1}; ++cell) {
          const double distance = glm::distance(points_[cell->second], at);
          if (distance >= least) continue;
          least = distance;
          best = cell->second;
        }
      }
    return best;
  }

 private:
  using Key = std::tuple<long, long, long>;
  using Cell = std::pair<Key, Index>;
  /// Cells are counted in whole numbers; single precision has none of an edge out there anyway.
  bool has_cell(const glm::dvec3& p) const {
    constexpr double kMost = 1e15;
    return std::abs(p.x) < kMost * edge_ && std::abs(p.y) < kMost * edge_ &&
           std::abs(p.z) < kMost * edge_;
  }
  Key key(const glm::dvec3& p) const {
    const auto cell = [&](double x) { return static_cast<long>(std::floor(x / edge_)); };
    return {cell(p.x), cell(p.y), cell(p.z)};
  }
  std::vector<glm::dvec3> points_;
  double edge_;
  std::vector<Cell> cells_;
};

void judge_symmetry(const Character& character, const Anatomy& anatomy,
                    const std::vector<std::uint32_t>& vertex, WeightHygiene& out) {
  const double edge = kMirrorTolerance * anatomy.height;
  if (!(edge > 0.0) || character.place_count == 0) return;
  const auto at = [&](int node) {
    return origin(character.nodes[static_cast<Index>(node)].world_from_node);
  };
  Mirror mirror{anatomy.left, at(anatomy.spine.front())};
  const auto& left = anatomy.left_arm.empty() ? anatomy.left_leg : anatomy.left_arm;
  const auto& right = anatomy.right_arm.empty() ? anatomy.right_leg : anatomy.right_arm;
  if (!left.empty() && !right.empty()) mirror.middle = 0.5 * (at(left.front()) + at(right.front()));

  const PosedMesh rest = rest_mesh(character);
  std::vector<glm::dvec3> points;
  for (const std::uint32_t v : vertex) points.emplace_back(rest.position[v]);
  const Cells cells(points, edge);
  const std::vector<int> other = mirrored_nodes(character, mirror);
  Index mirrored = 0;
  for (Index place = 0; place < points.size(); ++place) {
    const Index image = cells.nearest(mirror(points[place]));
    if (image == points.size()) continue;
    ++mirrored;
    const double apart = difference(character, other, vertex[place], vertex[image]);
    out.asymmetric += apart > kAsymmetryCounts;
    if (apart > out.worst_asymmetry) {
      out.worst_asymmetry = apart;
      out.worst_asymmetric_vertex = vertex[place];
    }
  }
  out.mirrored_share = static_cast<double>(mirrored) / static_cast<double>(points.size());
}

}  // namespace

int WeightHygiene::most_influences() const {
  for (int n = kMaxInfluences; n > 0; --n)
    if (with_influences[static_cast<Index>(n)] > 0) return n;
  return 0;
}

WeightHygiene judge_weights(const Character& character, const Anatomy& anatomy) {
  WeightHygiene out;
  const auto vertex = vertex_of_place(character);
  count_influences(character, out);
  find_bleed(character, vertex, out);
  judge_symmetry(character, anatomy, vertex, out);
  return out;
}

}  // namespace backbend::skin
