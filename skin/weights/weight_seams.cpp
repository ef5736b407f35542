#include "skin/weights/weight_seams.h"

#include <algorithm>
#include <array>
#include <map>
#include <numeric>
#include <optional>
#include <set>

#include "skin/weights/fault_map.h"
#include "skin/weights/plates.h"
#include "skin/weights/prop_parts.h"

namespace backbend::skin {
namespace {

using Index = std::size_t;

class SeamFinder {
 public:
  SeamFinder(const Character& character, const Anatomy& anatomy, const SkinPlaces& places)
      : character_(character),
        anatomy_(anatomy),
        places_(places),
        prop_(prop_parts(character, places)) {}

  WeightAnswer find() {
    FaultMap faults;
    // Of each place with several surfaces, the first vertex of each after the first surface's.
    std::map<Index, std::vector<Index>> others;
    for (Index v = 0; v < character_.vertex_count(); ++v) {
      const Index p = character_.place[v];
      if (places_.vertex[p] == v || places_.weights[p].empty()) continue;
      const PlaceWeights own = weights_of(character_, v);
      WeightDifference apart = weight_difference(places_.weights[p], own, nullptr);
      if (apart.share < kCounts) continue;
      if (!is_joined(places_.vertex[p], v)) {
        std::vector<Index>& first = others[p];
        const auto joined = std::ranges::find_if(first, [&](Index u) { return is_joined(u, v); });
        if (joined == first.end()) {
          first.push_back(v);
          continue;
        }
        apart = weight_difference(weights_of(character_, *joined), own, nullptr);
        if (apart.share < kCounts) continue;
      }
      // No motion of the spine parts eyelids from eyes.
      if (on_head(apart.most) && on_head(apart.least)) continue;
      add_fault(places_, faults, apart.most, apart.least, apart.share, 0.0, p);
    }
    WeightAnswer out;
    if (!faults.empty() && is_built_of_plates(character_, anatomy_))
      out.not_applicable = kPlatesPart;
    else
      take_faults(faults, out);
    return out;
  }

 private:
  /// The places of a part at which its surface ends: on an edge of one triangle alone.
  std::vector<bool> ends_of(const Part& part) const {
    std::vector<std::pair<Index, Index>> edges;
    for (Index t = part.first_triangle; t < part.first_triangle + part.triangle_count; ++t)
      for (int k = 0; k < 3; ++k) {
        const Index a = character_.place[character_.triangles[t][k]];
        const Index b = character_.place[character_.triangles[t][(k + 1) % 3]];
        edges.emplace_back(std::min(a, b), std::max(a, b));
      }
    std::sort(edges.begin(), edges.end());
    std::vector<bool> out(places_.weights.size(), false);
    for (std::size_t i = 0, next = 0; i < edges.size(); i = next) {
      for (next = i; next < edges.size() && edges[next] == edges[i];) ++next;
      if (next - i == 1) out[edges[i].first] = out[edges[i].second] = true;
    }
    return out;
  }

  /// The places of the triangles around each place.
  void find_fans() {
    fans_.resize(places_.weights.size());
    for (const auto& triangle : character_.triangles)
      for (int k = 0; k < 3; ++k)
        fans_[character_.place[triangle[k]]].push_back(
            {triangle[k],
             {character_.place[triangle[(k + 1) % 3]], character_.place[triangle[(k + 2) % 3]]}});
  }

  /// Whether two vertices of one part and place are of one surface there: a walk from triangle to
  /// triangle over the edges at this place leads from one to the other. Lips that meet in a point
  /// share no edge. Where the same triangle lies there twice and faces the same way, as in feathers
  /// folded upon each other, its edges lead nowhere.
  bool is_one_fan(const Part& part, Index a, Index b) {
    if (fans_.empty()) find_fans();
    std::vector<Corner> fan = fans_[character_.place[a]];
    std::erase_if(fan, [&](const Corner& corner) {
      return corner.vertex < part.first_vertex ||
             corner.vertex >= part.first_vertex + part.vertex_count;
    });
    std::map<Index, std::vector<std::size_t>> beside;  // the triangles on each edge, by its end
    for (std::size_t i = 0; i < fan.size(); ++i)
      for (const Index end : fan[i].others) beside[end].push_back(i);
    std::vector<std::size_t> surface(fan.size());
    std::iota(surface.begin(), surface.end(), std::size_t{0});
    const auto join = [&](std::size_t i, std::size_t j) {
      const std::size_t from = surface[j], to = surface[i];
      std::ranges::replace(surface, from, to);
    };
    for (std::size_t i = 0; i < fan.size(); ++i)
      for (std::size_t j = 0; j < i; ++j)
        if (fan[i].vertex == fan[j].vertex) join(i, j);
    for (const auto& [end, triangles] : beside) {
      std::set<std::pair<bool, Index>> sides;  // the way round the edge, and the place across it
      for (const std::size_t i : triangles)
        sides.emplace(fan[i].others[0] == end, fan[i].others[fan[i].others[0] == end ? 1 : 0]);
      if (sides.size() < triangles.size()) continue;
      for (const std::size_t i : triangles) join(triangles.front(), i);
    }
    std::optional<std::size_t> of_a, of_b;
    for (std::size_t i = 0; i < fan.size(); ++i) {
      if (fan[i].vertex == a) of_a = surface[i];
      if (fan[i].vertex == b) of_b = surface[i];
    }
    return of_a && of_b && *of_a == *of_b;
  }

  /// Whether vertices at one place belong to one surface: of one part of the mesh, or of two that
  /// both end there and of which none is a prop. A shield that touches another goes its own way.
  bool is_joined(Index a, Index b) {
    const auto part_of = [&](Index v) {
      Index k = 0;
      while (k + 1 < character_.parts.size() &&
             v >= character_.parts[k].first_vertex + character_.parts[k].vertex_count)
        ++k;
      return k;
    };
    const Index first = part_of(a), second = part_of(b);
    if (first == second) return is_one_fan(character_.parts[first], a, b);
    if (ends_.empty()) ends_.resize(character_.parts.size());
    for (const Index part : {first, second}) {
      if (ends_[part].empty()) {
        ends_[part] = prop_[part] >= 0 ? std::vector<bool>(places_.weights.size(), false)
                                       : ends_of(character_.parts[part]);
      }
      if (!ends_[part][character_.place[a]]) return false;
    }
    return true;
  }

  /// Whether a joint is the head or hangs from it.
  bool on_head(int node) const {
    while (node >= 0 && node != anatomy_.head)
      node = character_.nodes[static_cast<Index>(node)].parent;
    return node >= 0;
  }

  /// A triangle at a place: its vertex there, and the places of the other two.
  struct Corner {
    Index vertex;
    std::array<Index, 2> others;
  };

  const Character& character_;
  const Anatomy& anatomy_;
  const SkinPlaces& places_;
  const std::vector<int> prop_;  // of each part: the node of the prop that it is of, or -1
  std::vector<std::vector<Corner>> fans_;  // of each place; made when first asked
  /// Of each part, by place: where its surface ends. A prop's ends nowhere.
  std::vector<std::vector<bool>> ends_;
};

}  // namespace

WeightAnswer find_seam_faults(const Character& character, const Anatomy& anatomy,
                              const SkinPlaces& places) {
  return SeamFinder(character, anatomy, places).find();
}

}  // namespace backbend::skin
