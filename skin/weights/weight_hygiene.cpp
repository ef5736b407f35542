#include "skin/weights/weight_hygiene.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <numeric>
#include <tuple>

#include "skin/anatomy/mirror_image.h"
#include "skin/character/point_cells.h"
#include "skin/deform/skinning.h"

namespace backbend::skin {
namespace {

using Index = std::size_t;

constexpr double kMirrorTolerance = 0.002;  // of the height
constexpr double kAsymmetryCounts = 0.05;
constexpr std::size_t kLeastPiece = 12;  // places: as few as a cube with its edges cut
constexpr float kFixed = 0.9f;

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
  // Shells are counted part by part: where a costume's vertices stand on the body's they touch, no
  // more.
  Sets shells(character.vertex_count());
  std::map<std::pair<Index, Index>, Index> first_at;  // vertex of a part at a place
  for (Index part = 0; part < character.parts.size(); ++part)
    for (Index v = character.parts[part].first_vertex;
         v < character.parts[part].first_vertex + Index{character.parts[part].vertex_count}; ++v)
      shells.join(v, first_at.try_emplace({part, character.place[v]}, v).first->second);
  const auto weighs = [&](Index place, Index k) {
    return character.influences[vertex[place]].weight[k] > kTinyWeight;
  };
  for (const glm::uvec3& triangle : character.triangles)
    for (int corner = 0; corner < 3; ++corner) {
      const Index a = character.place[triangle[corner]];
      const Index b = character.place[triangle[(corner + 1) % 3]];
      shells.join(triangle[corner], triangle[(corner + 1) % 3]);
      for (Index i = 0; i < kMaxInfluences && weighs(a, i); ++i)
        for (Index k = 0; k < kMaxInfluences && weighs(b, k); ++k)
          if (node_of(character, character.influences[vertex[a]], i) ==
              node_of(character, character.influences[vertex[b]], k))
            islands.join(a * kMaxInfluences + i, b * kMaxInfluences + k);
    }

  struct Island {
    double weight = 0.0;
    float least = 1.0f;  // of the joint's weights in it
    Bleed facts;
  };
  std::map<std::tuple<int, Index, Index>, Island> found;  // node, shell, island
  for (Index place = 0; place < character.place_count; ++place)
    for (Index k = 0; k < kMaxInfluences && weighs(place, k); ++k) {
      const Influences& influences = character.influences[vertex[place]];
      const int node = node_of(character, influences, k);
      Island& island =
          found[{node, shells.find(vertex[place]), islands.find(place * kMaxInfluences + k)}];
      island.weight += influences.weight[k];
      island.least = std::min(island.least, influences.weight[k]);
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
      // A buckle or a plate that is fixed to one joint all over was not painted by accident.
      if (island.places >= kLeastPiece && at->second.least >= kFixed) continue;
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

void judge_symmetry(const Character& character, const Anatomy& anatomy,
                    const std::vector<std::uint32_t>& vertex, WeightHygiene& out) {
  const double edge = kMirrorTolerance * anatomy.height;
  if (!(edge > 0.0) || character.place_count == 0) return;
  const PosedMesh rest = rest_mesh(character);
  std::vector<glm::dvec3> points;
  for (const std::uint32_t v : vertex) points.emplace_back(rest.position[v]);
  const Mirror mirror = surface_mirror(character, anatomy, points);
  const PointCells cells(points, edge);
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
