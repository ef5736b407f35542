#include "skin/weights/weight_faults.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <map>
#include <memory>
#include <numeric>
#include <optional>
#include <set>

#include "skin/anatomy/chain_arc.h"
#include "skin/anatomy/import_checks.h"
#include "skin/anatomy/mirror_image.h"
#include "skin/character/closest_point.h"
#include "skin/character/matrix_facts.h"
#include "skin/character/point_cells.h"
#include "skin/character/printable.h"
#include "skin/deform/skinning.h"
#include "skin/weights/weight_borders.h"

namespace backbend::skin {
namespace {

using Index = std::size_t;

// Lengths are shares of the body's largest side.
constexpr double kOffMiddle = 0.12;     // nearer the middle both sides share vertices
constexpr double kAsFarOut = 0.6;       // ... or further out than this share of the joint's own
constexpr double kAcross = 0.9;         // ... of the joint's own, from its area
constexpr double kFar = 0.15;           // from a joint's area
constexpr double kSpilt = 0.2;          // a weight that fades halves within less
constexpr double kIsland = 0.08;        // ... and one that stands alone needs no more
constexpr double kShellGap = 0.03;      // from one shell to another that it lies on
constexpr double kPiece = 0.05;         // of the places: a piece of costume, bound as a whole
constexpr std::size_t kArmJoints = 2;   // of an arm: clavicle and upper arm
constexpr double kFarJoints = 3.0;      // along the skeleton
constexpr double kHumpJoints = 2.0;     // ... for a weight that rises again where it should fade
constexpr double kLedJoints = 2.5;      // ... and leads there, as far off as kFar
constexpr double kWhole = 0.95;         // of a joint's largest weight: as much as anywhere
constexpr double kHump = 0.04;          // of a vertex's weight: how far it rises
constexpr double kFarSpine = 0.4;       // of the spine's length, where its joints stand densely
constexpr double kLeads = 0.25;         // of a joint's weight, where it weighs most: else no area
constexpr double kOverlaps = 0.3;       // of the way between two joints, for a fault of their order
constexpr double kApartInOrder = 0.4;   // of the torso's half width, for joints to have an order
constexpr double kCounts = 0.01;        // less of a vertex's weight is a crumb
constexpr double kMostly = 0.5;         // of a place's weight, for the spine to move it
constexpr double kNothing = 0.02;       // of the weight of the joint above: smeared wholly
constexpr double kOffBone = 0.6;        // of a bone, between a joint and where its weights begin
constexpr double kOffBoneMost = 1.4;    // ... at most: what is further off is the body's own way
constexpr double kLongBone = 0.6;       // of the torso's half width: else it has no rows of its own
constexpr double kMirrored = 0.95;      // of the places, to speak of a symmetric body
constexpr double kMirrorSlack = 0.002;  // between a place and its image
constexpr double kSamePlace = 1e-5;     // between places where shells touch
constexpr double kSurfaceSlack = 0.01;  // ... and the surface, where no place has one
constexpr double kUnlikeSides = 0.42;   // of a joint's weight, between sides of other vertices
constexpr double kLeastUnlike = 0.005;  // of all weight, for a side of a joint to be compared so
constexpr double kJointSlack = 0.01;    // between a joint and its image
constexpr double kPatch = 0.005;        // of the places, and ...
constexpr double kWidePatch = 0.01;     // ... of a hump with its slope
constexpr std::size_t kLeastForSlopes = 1000;  // places: on fewer a joint's area is all slope
constexpr double kPatchPlaces = 6.0;           // ... this many: fewer are single slips
constexpr double kHeavy = 0.2;                 // of a vertex's weight: few places show it, ...
constexpr double kPlacesHeavy = 4.0;           // ... and fewer are slips
constexpr double kPlacesBehind = 24.0;     // of a joint above the hips: low bodies leave it a few
constexpr double kShareBehind = 0.02;      // ... and of all places
constexpr double kHeldBehind = 0.08;       // of a vertex's weight: it is held back in plain sight
constexpr double kHeldAround = 0.05;       // ... and so much
constexpr double kPlacesHeld = 12.0;       // ... on these many places
constexpr double kShareHeld = 0.009;       // ... and of all
constexpr double kPlacesUneven = 12.0;     // ... where both sides do not have it alike
constexpr double kUneven = 0.25;           // of its places
constexpr double kDiffers = 0.05;          // of a vertex's weight, between a place and its image
constexpr double kUnevenTorso = 0.03;      // of the torso's places: not painted to mirror itself
constexpr double kMostOfTorso = 0.15;      // ... for a patch of it
constexpr double kMostOfTorsoRisen = 0.6;  // ... that is a hump
constexpr double kMostlyRisen = 0.5;       // of its places
constexpr double kSmallPatch = 0.002;      // of all places, for such a patch
constexpr double kNearImage = 0.03;        // from a place's image
constexpr double kLeastOneSided = 0.08;    // of a vertex's weight, for such a patch
constexpr std::size_t kPlacesRisen = 2;    // ... of which at the top
constexpr double kPlacesOneSided = 8.0;    // of a patch that the other side has nowhere near
constexpr double kOneSided = 0.8;          // of the weight, at most, at the place's mirror image
constexpr double kFollows = 0.25;          // of its weight, where a joint leads
constexpr double kLeastArea = 0.002;       // of all weight: less has no middle to speak of

/// The weights of one place on nodes.
struct NodeWeight {
  int node = -1;
  double weight = 0.0;
};
using PlaceWeights = std::vector<NodeWeight>;

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

/// Half the sum of the differences between two places' weights, 0..1, and the joint with the
/// largest; `image` leads from the first one's joints to the second's.
struct Difference {
  double share = 0.0;
  int most = -1, least = -1;  // where the second has most more and most less than the first
};
Difference difference(const PlaceWeights& a, const PlaceWeights& b, const std::vector<int>* image) {
  std::map<int, double> sum;
  for (const NodeWeight& w : a)
    sum[image ? (*image)[static_cast<Index>(w.node)] : w.node] -= w.weight;
  for (const NodeWeight& w : b) sum[w.node] += w.weight;
  Difference out;
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

class FaultFinder {
 public:
  FaultFinder(const Character& character, const Anatomy& anatomy)
      : character_(character), anatomy_(anatomy), mirror_(mirror_of(character, anatomy)) {
    std::vector<bool> unweighted(character.vertex_count(), false);
    for (const std::uint32_t v : character.unweighted) unweighted[v] = true;
    vertex_.assign(character.place_count, 0);
    weights_.resize(character.place_count);
    for (Index v = character.vertex_count(); v-- > 0;)
      vertex_[character.place[v]] = static_cast<std::uint32_t>(v);
    const PosedMesh rest = rest_mesh(character);
    for (const std::uint32_t v : vertex_) point_.emplace_back(rest.position[v]);
    for (Index p = 0; p < weights_.size(); ++p)
      if (!unweighted[vertex_[p]]) weights_[p] = weights_of(character, vertex_[p]);
    for (const Node& node : character.nodes) parent_.push_back(node.parent);
    for (const Follower& one : anatomy.followers)
      parent_[static_cast<Index>(one.node)] = one.leader;
    main_.assign(weights_.size(), -1);
    total_.assign(character.nodes.size(), 0.0);
    for (Index p = 0; p < weights_.size(); ++p) {
      double most = 0.0;
      for (const NodeWeight& w : weights_[p]) {
        total_[static_cast<Index>(w.node)] += w.weight;
        if (w.weight > most) {
          most = w.weight;
          main_[p] = w.node;
        }
      }
    }
    glm::dvec3 low = point_.empty() ? glm::dvec3(0.0) : point_.front(), high = low;
    for (const glm::dvec3& p : point_) {
      low = glm::min(low, p);
      high = glm::max(high, p);
    }
    const glm::dvec3 sides = high - low;
    size_ = std::max({sides.x, sides.y, sides.z});
    all_ = std::accumulate(total_.begin(), total_.end(), 0.0);
    measure_torso();
  }

  WeightFaults find() {
    WeightFaults out;
    if (!(size_ > 0.0) || !(all_ > 0.0)) return out;
    image_ = mirrored_nodes(character_, mirror_);
    find_distant(out);
    find_one_sided(out.far);
    find_asymmetry(out.asymmetry, out.wrong_side);
    find_order(out.order);
    find_seams(out.seams);
    return out;
  }

 private:
  glm::dvec3 at(int node) const {
    return origin(character_.nodes[static_cast<Index>(node)].world_from_node);
  }

  /// The chain of the spine's joints, and how far the torso's surface is from it.
  void measure_torso() {
    place_on_spine_.assign(total_.size(), -1);
    for (Index k = 0; k < anatomy_.spine.size(); ++k) {
      place_on_spine_[static_cast<Index>(anatomy_.spine[k])] = static_cast<int>(k);
      chain_.push_back(at(anatomy_.spine[k]));
      arc_.push_back(k == 0 ? 0.0 : arc_.back() + glm::distance(chain_[k - 1], chain_[k]));
    }
    along_.assign(weights_.size(), 0.0);
    beside_.assign(weights_.size(), 0.0);
    double sum = 0.0, weight = 0.0;
    for (Index p = 0; p < weights_.size(); ++p)
      for (const NodeWeight& w : weights_[p]) {
        const int k = place_on_spine_[static_cast<Index>(w.node)];
        if (k < 0) continue;
        if (!(beside_[p] > 0.0)) {
          along_[p] = nearest_arc(chain_, point_[p]);
          beside_[p] = glm::distance(point_at(along_[p]), point_[p]);
        }
        if (static_cast<Index>(k) > anatomy_.chest_index) continue;
        sum += w.weight * beside_[p];
        weight += w.weight;
      }
    half_width_ = weight > 0.0 ? sum / weight : 0.0;
    spine_step_ = std::max(kFarSpine * arc_[anatomy_.chest_index], half_width_) / kFarJoints;
  }

  glm::dvec3 point_at(double arc) const {
    Index k = 1;
    while (k + 1 < chain_.size() && arc_[k] < arc) ++k;
    const double step = arc_[k] - arc_[k - 1];
    return step > 0.0 ? glm::mix(chain_[k - 1], chain_[k], (arc - arc_[k - 1]) / step) : chain_[k];
  }

  /// What the way from a joint to the one above it counts: nothing where they stand in one place,
  /// and of a spine of many joints, where three are a short way, by its length.
  double step_above(int node) const {
    const int above = parent_[static_cast<Index>(node)];
    if (above < 0) return 1.0;
    if (glm::distance(at(node), at(above)) < kSamePlace * size_) return 0.0;
    if (place_on_spine_[static_cast<Index>(node)] < 0 ||
        place_on_spine_[static_cast<Index>(above)] < 0)
      return 1.0;
    return std::min(1.0, glm::distance(at(node), at(above)) / spine_step_);
  }

  /// Joints on the way from one to another along the skeleton.
  double steps_between(int a, int b) const {
    std::vector<std::pair<int, double>> up;
    double steps = 0.0;
    for (int n = a; n >= 0 && up.size() < parent_.size(); n = parent_[static_cast<Index>(n)]) {
      up.emplace_back(n, steps);
      steps += step_above(n);
    }
    steps = 0.0;
    Index count = 0;
    for (int n = b; n >= 0 && count < parent_.size(); n = parent_[static_cast<Index>(n)], ++count) {
      const auto found =
          std::find_if(up.begin(), up.end(), [&](const auto& e) { return e.first == n; });
      if (found != up.end()) return steps + found->second;
      steps += step_above(n);
    }
    return std::numeric_limits<double>::infinity();  // of another root
  }

  /// The area of a joint: places where it weighs most, of one that hardly does those where it
  /// weighs at least half as much as anywhere; and its bone.
  double distance_to_area(int node, const glm::dvec3& point, double enough) {
    auto& cells = area_[node];
    if (!cells) {
      std::vector<glm::dvec3> points;
      const double half = 0.5 * largest_weight(node);
      const bool leads =
          half >= 0.5 * kMostly && std::find(main_.begin(), main_.end(), node) != main_.end();
      for (Index p = 0; p < main_.size(); ++p)
        if (leads ? main_[p] == node && hump_at(node, p) != Hump::leads
                  : half > 0.0 && weight_at(p, node) >= half && hump_at(node, p) == Hump::none)
          points.push_back(point_[p]);
      for (const glm::dvec3& on_bone : points_on_bones(node)) points.push_back(on_bone);
      cells = std::make_unique<PointCells>(std::move(points), kFar * size_);
    }
    const Index nearest = cells->nearest(point);
    return nearest == cells->size() ? enough : glm::distance(cells->point(nearest), point);
  }

  /// Whether no edges lead from a place to the joint's area over places that it weighs, too. On
  /// another shell, a costume's, it has an area of its own.
  bool stands_alone(int node, Index place) {
    auto& island = island_[node];
    if (island.empty()) {
      if (edges_.of.empty()) list_edges();
      island.assign(weights_.size(), false);
      std::vector<bool> has(weights_.size(), false);
      std::vector<Index> pending;
      for (Index p = 0; p < weights_.size(); ++p)
        for (const NodeWeight& w : weights_[p])
          if (w.node == node && w.weight >= kCounts) has[p] = true;
      // From all places where it weighs most: what is not reached stands alone. A joint that weighs
      // most nowhere has its area where it weighs at least half as much as anywhere.
      const bool leads = std::find(main_.begin(), main_.end(), node) != main_.end();
      const double largest = largest_weight(node);
      std::vector<bool> reached(weights_.size(), false);
      for (Index p = 0; p < weights_.size(); ++p)
        if (leads ? main_[p] == node : weight_at(p, node) >= 0.5 * largest) {
          reached[p] = true;
          pending.push_back(p);
        }
      while (!pending.empty()) {
        const Index p = pending.back();
        pending.pop_back();
        for (Index e = linked_.first[p]; e < linked_.first[p + 1]; ++e)
          if (has[linked_.of[e]] && !reached[linked_.of[e]]) {
            reached[linked_.of[e]] = true;
            pending.push_back(linked_.of[e]);
          }
      }
      for (Index p = 0; p < weights_.size(); ++p) island[p] = has[p] && !reached[p];
    }
    return island[place];
  }

  /// Whether a place is on a hump of the joint's weight: from the joint's heaviest place to there
  /// the weight falls, over edges of the mesh, and then rises again by kHump or more. Painted
  /// weights fall from their area on; what rises again was spilt, or is a second area of the
  /// joint's own.
  enum class Hump : char { none, small, leads };  // leads: the joint weighs most somewhere
  Hump hump_at(int node, Index place) {
    auto& hump = hump_[node];
    if (hump.empty()) hump = humps_of(node);
    return hump[place];
  }

  /// By flooding from the heaviest place down (0-dimensional persistence): where two risen areas
  /// meet, the lower peak's is a hump as high as its peak is above the meeting place.
  std::vector<Hump> humps_of(int node) {
    if (edges_.of.empty()) list_edges();
    struct Area {
      Index peak = 0;  // its heaviest place
      std::vector<Index> places;
    };
    std::vector<std::pair<double, Index>> order;
    for (Index p = 0; p < weights_.size(); ++p)
      if (const double w = weight_at(p, node); w > 0.0) order.emplace_back(-w, p);
    std::sort(order.begin(), order.end());
    std::vector<Area> areas;
    constexpr Index kDry = static_cast<Index>(-1);
    std::vector<Index> area_of(weights_.size(), kDry);
    std::vector<Hump> hump(weights_.size(), Hump::none);
    std::vector<double>& peak_weight = hump_peak_[node];
    peak_weight.assign(weights_.size(), 0.0);
    const auto mark = [&](const Area& area) {
      const bool leads =
          std::ranges::any_of(area.places, [&](Index q) { return main_[q] == node; });
      const Hump kind = leads ? Hump::leads : Hump::small;
      for (const Index q : area.places) {
        hump[q] = kind;
        peak_weight[q] = weight_at(area.peak, node);
      }
    };
    for (const auto& [negative, p] : order) {
      Index own = kDry;
      for (Index e = linked_.first[p]; e < linked_.first[p + 1]; ++e) {
        const Index other = area_of[linked_.of[e]];
        if (other == kDry || other == own) continue;
        if (own == kDry) {
          own = other;
          continue;
        }
        const bool own_is_lower =
            weight_at(areas[own].peak, node) < weight_at(areas[other].peak, node);
        const Area& lower = areas[own_is_lower ? own : other];
        if (weight_at(lower.peak, node) + negative >= kHump) mark(lower);
        const Index peak = areas[own_is_lower ? other : own].peak;
        // The smaller one's places go over to the larger.
        const bool own_is_smaller = areas[own].places.size() < areas[other].places.size();
        Area& from = areas[own_is_smaller ? own : other];
        own = own_is_smaller ? other : own;
        for (const Index q : from.places) area_of[q] = own;
        areas[own].places.insert(areas[own].places.end(), from.places.begin(), from.places.end());
        areas[own].peak = peak;
        from.places.clear();
      }
      if (own == kDry) {
        own = areas.size();
        areas.push_back({p, {}});
      }
      area_of[p] = own;
      areas[own].places.push_back(p);
    }
    // What no edges join to the heaviest.
    for (const Area& area : areas)
      if (!area.places.empty() && area_of[area.peak] != area_of[order.front().second] &&
          weight_at(area.peak, node) >= kHump)
        mark(area);
    return hump;
  }

  /// The joint that weighs most on a place beside `node`; -1 for none.
  int heaviest_but(Index place, int node) const {
    int best = -1;
    double most = 0.0;
    for (const NodeWeight& w : weights_[place])
      if (w.node != node && w.weight > most) {
        most = w.weight;
        best = w.node;
      }
    return best;
  }

  double largest_weight(int node) const {
    double largest = 0.0;
    for (Index p = 0; p < weights_.size(); ++p) largest = std::max(largest, weight_at(p, node));
    return largest;
  }

  double weight_at(Index place, int node) const {
    for (const NodeWeight& w : weights_[place])
      if (w.node == node) return w.weight;
    return 0.0;
  }

  /// The neighbours of each place, one after another.
  struct Neighbours {
    std::vector<Index> first, of;  // of place p: of[first[p]] to of[first[p + 1] - 1]
    Neighbours() = default;
    Neighbours(const std::vector<std::pair<Index, Index>>& pairs, Index places)
        : first(places + 1, 0), of(pairs.size()) {
      for (const auto& [a, b] : pairs) ++first[a + 1];
      for (Index p = 0; p < places; ++p) first[p + 1] += first[p];
      std::vector<Index> next(first.begin(), first.end() - 1);
      for (const auto& [a, b] : pairs) of[next[a]++] = b;
      for (Index p = 0; p < places; ++p)
        std::sort(of.begin() + static_cast<std::ptrdiff_t>(first[p]),
                  of.begin() + static_cast<std::ptrdiff_t>(first[p + 1]));
    }
  };

  void list_edges() {
    std::vector<std::pair<Index, Index>> pairs;
    for (const glm::uvec3& t : character_.triangles)
      for (int k = 0; k < 3; ++k) {
        const Index a = character_.place[t[k]], b = character_.place[t[(k + 1) % 3]];
        pairs.emplace_back(a, b);
        pairs.emplace_back(b, a);
      }
    edges_ = Neighbours(pairs, weights_.size());
    find_shells();
    link_shells(pairs);
    linked_ = Neighbours(pairs, weights_.size());
  }

  /// The pieces of the surface that no edges join.
  void find_shells() {
    const Index none = weights_.size();
    shell_.assign(weights_.size(), none);
    std::vector<Index> pending;
    for (Index start = 0; start < shell_.size(); ++start) {
      if (shell_[start] != none) continue;
      shell_[start] = shell_size_.size();
      shell_size_.push_back(0);
      pending.push_back(start);
      while (!pending.empty()) {
        const Index p = pending.back();
        pending.pop_back();
        ++shell_size_.back();
        for (Index e = edges_.first[p]; e < edges_.first[p + 1]; ++e)
          if (shell_[edges_.of[e]] == none) {
            shell_[edges_.of[e]] = shell_size_.size() - 1;
            pending.push_back(edges_.of[e]);
          }
      }
    }
    largest_shell_ = static_cast<Index>(std::max_element(shell_size_.begin(), shell_size_.end()) -
                                        shell_size_.begin());
  }

  /// From each place of a shell to the nearest place of another: a belt's or a tuft's weights go on
  /// where the body's below them do, though no edge leads there. The largest shell's places ask
  /// for none.
  void link_shells(std::vector<std::pair<Index, Index>>& pairs) const {
    if (shell_size_.size() < 2) return;
    const PointCells cells(point_, kShellGap * size_);
    for (Index p = 0; p < shell_.size(); ++p) {
      if (shell_[p] == largest_shell_) continue;
      const Index q = cells.nearest(point_[p], [&](Index i) { return shell_[i] != shell_[p]; });
      if (q == cells.size()) continue;
      pairs.emplace_back(p, q);
      pairs.emplace_back(q, p);
    }
  }

  /// Whether a joint weighs on all of a small shell: a piece of costume that was bound so as a
  /// whole.
  bool holds_shell(int node, Index place) {
    if (edges_.of.empty()) list_edges();
    const Index shell = shell_[place];
    if (shell == largest_shell_ ||
        static_cast<double>(shell_size_[shell]) > kPiece * static_cast<double>(shell_.size()))
      return false;
    auto& held = held_[node];
    if (held.empty()) {
      held.assign(shell_size_.size(), 0);
      for (Index p = 0; p < shell_.size(); ++p)
        if (weight_at(p, node) >= kCounts) ++held[shell_[p]];
    }
    return held[shell] == shell_size_[shell];
  }

  /// How far the nearest place is at which a joint weighs twice as much, or about as much as it
  /// does anywhere: short where its weight fades, long where it was spilt.
  double distance_to_double(int node, double weight, const glm::dvec3& point) {
    auto& places = places_of_[node];
    if (places.empty())
      for (Index p = 0; p < weights_.size(); ++p)
        for (const NodeWeight& w : weights_[p])
          if (w.node == node) places.emplace_back(w.weight, p);
    double largest = 0.0;
    for (const auto& [w, place] : places) largest = std::max(largest, w);
    const double enough = std::min(2.0 * weight, kWhole * largest);
    double nearest = glm::distance(at(node), point);
    for (const auto& [w, place] : places)
      if (w >= enough) nearest = std::min(nearest, glm::distance(point_[place], point));
    return nearest;
  }

  void add(std::map<int, WeightFault>& faults, int node, int other, double share, double distance,
           Index place) {
    WeightFault& fault = faults[node];
    ++fault.places;
    fault.vertices.push_back(vertex_[place]);
    fault.distance = std::max(fault.distance, distance);
    if (share <= fault.value) return;
    fault.node = node;
    fault.other = other;
    fault.value = share;
    fault.vertex = vertex_[place];
  }

  /// Single slips are for the check of stray vertices.
  void keep_patches(std::map<int, WeightFault>& faults, double fewest = kPatchPlaces,
                    double share = kPatch) const {
    const double least = std::max(fewest, share * static_cast<double>(point_.size()));
    for (auto each = faults.begin(); each != faults.end();)
      each =
          static_cast<double>(each->second.places) < least ? faults.erase(each) : std::next(each);
  }

  static void take(std::map<int, WeightFault>& from, WeightAnswer& to) {
    for (auto& [node, fault] : from) to.faults.push_back(fault);
    std::stable_sort(to.faults.begin(), to.faults.end(),
                     [](const WeightFault& a, const WeightFault& b) { return a.value > b.value; });
  }

  /// Whether the hips hang from a joint: it stays behind when the spine moves.
  bool above_hips(int node) const {
    for (int n = character_.nodes[static_cast<Index>(anatomy_.spine.front())].parent; n >= 0;
         n = character_.nodes[static_cast<Index>(n)].parent)
      if (n == node) return true;
    return false;
  }

  /// Whether a joint is a knee or an elbow, or beyond one.
  bool lower_limb(int node) const {
    for (const std::vector<int>* limb :
         {&anatomy_.left_arm, &anatomy_.right_arm, &anatomy_.left_leg, &anatomy_.right_leg})
      for (Index k = kArmJoints; k < limb->size(); ++k)
        if ((*limb)[k] == node) return true;
    return false;
  }

  /// Whether a joint has weight, and hardly anywhere the most.
  bool follows(int node) const {
    double leads = 0.0;
    for (Index p = 0; p < main_.size(); ++p)
      if (main_[p] == node) leads += weight_at(p, node);
    return leads < kFollows * total_[static_cast<Index>(node)];
  }

  /// Whether a joint is a vertebra above the hips, up to the chest.
  bool on_torso(int node) const {
    const int on = place_on_spine_[static_cast<Index>(node)];
    return on > 0 && on <= static_cast<int>(anatomy_.chest_index);
  }

  /// Whether a joint is a vertebra above the hips, neck and head among them.
  bool is_vertebra(int node) const { return place_on_spine_[static_cast<Index>(node)] > 0; }

  /// What vertebrae move and a joint above the hips keeps; on few places only where it keeps much,
  /// or where both sides do not have it alike (a belly that was left to the whole body's joint has
  /// it on both). A spine that hangs from its chest has vertebrae above the hips, which do move.
  /// Which joints are meant.
  std::vector<bool> find_behind(WeightAnswer& out) {
    std::vector<bool> meant(total_.size(), false);
    for (Index n = 0; n < total_.size(); ++n)
      meant[n] = total_[n] > 0.0 && place_on_spine_[n] < 0 && above_hips(static_cast<int>(n)) &&
                 follows(static_cast<int>(n));
    std::map<int, WeightFault> all, held, one_sided;
    for (Index p = 0; p < weights_.size(); ++p)
      for (const NodeWeight& w : weights_[p]) {
        if (w.weight < kCounts || !meant[static_cast<Index>(w.node)]) continue;
        const int rival = heaviest_but(p, w.node);
        if (rival < 0 || !is_vertebra(rival)) continue;
        const double distance = glm::distance(at(w.node), point_[p]);
        add(all, w.node, rival, w.weight, distance, p);
        if (w.weight >= kHeldAround) add(held, w.node, rival, w.weight, distance, p);
        double there = 0.0;
        for (const NodeWeight& other : weights_of_images()[p])
          if (other.node == w.node) there += other.weight;
        if (there <= kOneSided * w.weight) add(one_sided, w.node, rival, w.weight, distance, p);
      }
    std::map<int, WeightFault> uneven;
    for (const auto& [node, fault] : all)
      if (const auto side = one_sided.find(node);
          side != one_sided.end() && side->second.places >= kUneven * fault.places)
        uneven.insert({node, fault});
    keep_patches(uneven, kPlacesUneven, kSmallPatch);
    keep_patches(all, kPlacesBehind, kShareBehind);
    keep_patches(held, kPlacesHeld, kShareHeld);
    std::erase_if(held, [](const auto& each) { return each.second.value < kHeldBehind; });
    for (const auto* more : {&all, &held}) uneven.insert(more->begin(), more->end());
    take(uneven, out);
    return meant;
  }

  /// Points along a joint's bones.
  std::vector<glm::dvec3> points_on_bones(int node) const {
    std::vector<glm::dvec3> points{at(node)};
    for (Index n = 0; n < character_.nodes.size(); ++n)
      if (character_.nodes[n].parent == node && total_[n] > 0.0) {
        const glm::dvec3 end = at(static_cast<int>(n));
        for (int k = 1; k <= 4; ++k) points.push_back(glm::mix(at(node), end, 0.25 * k));
      }
    return points;
  }

  /// A patch of one shell that one joint moves most.
  struct Patch {
    std::vector<Index> places;
    std::map<int, Index> around;  // edges that lead out of it, by the joint that moves most there
    std::map<int, Index> below;   // what it lies on, of a shell other than the largest: as `around`
    bool is_shell = false;        // nothing else is on its shell
  };

  /// The patches of each joint.
  std::map<int, std::vector<Patch>> patches_of_joints() {
    if (edges_.of.empty()) list_edges();
    std::map<int, std::vector<Patch>> out;
    std::vector<bool> done(main_.size(), false);
    for (Index start = 0; start < main_.size(); ++start) {
      if (done[start] || main_[start] < 0) continue;
      Patch& patch = out[main_[start]].emplace_back();
      patch.places.push_back(start);
      done[start] = true;
      for (Index next = 0; next < patch.places.size(); ++next) {
        const Index p = patch.places[next];
        for (Index e = edges_.first[p]; e < edges_.first[p + 1]; ++e) {
          const Index q = edges_.of[e];
          if (main_[q] != main_[start]) {
            if (main_[q] >= 0) ++patch.around[main_[q]];
          } else if (!done[q]) {
            done[q] = true;
            patch.places.push_back(q);
          }
        }
      }
      patch.is_shell = patch.places.size() == shell_size_[shell_[start]];
      if (!patch.is_shell && shell_[start] == largest_shell_) continue;
      for (const Index p : patch.places)
        for (Index e = linked_.first[p]; e < linked_.first[p + 1]; ++e)
          if (const Index q = linked_.of[e]; shell_[q] != shell_[p] && main_[q] >= 0)
            ++patch.below[main_[q]];
    }
    return out;
  }

  /// Patches far from a joint's bones and from its area there, amid what joints far along the
  /// skeleton move; other joints need not weigh on them. Or, of a piece of costume, where all that
  /// they lie on is so far: gloves and sleeves that were swapped are amid each other's joints.
  void find_cut_off(std::map<int, WeightFault>& out) {
    for (const auto& [node, patches] : patches_of_joints()) {
      if (patches.size() < 2) continue;
      std::vector<glm::dvec3> own = points_on_bones(node);
      const PointCells bones(own, kFar * size_);
      const auto off = [&](const PointCells& cells, const Patch& patch) {
        double nearest = std::numeric_limits<double>::infinity();
        for (const Index p : patch.places) {
          const Index found = cells.nearest(point_[p]);
          // What is further off than the cells reach is told by the joint itself.
          const glm::dvec3 own_place = found < cells.size() ? cells.point(found) : at(node);
          nearest = std::min(nearest, glm::distance(own_place, point_[p]));
        }
        return nearest;
      };
      std::vector<double> off_bones;
      for (const Patch& patch : patches) off_bones.push_back(off(bones, patch));
      const auto area = std::min_element(off_bones.begin(), off_bones.end()) - off_bones.begin();
      for (const Index p : patches[static_cast<Index>(area)].places) own.push_back(point_[p]);
      const PointCells cells(std::move(own), kFar * size_);
      for (Index k = 0; k < patches.size(); ++k) {
        const Patch& patch = patches[k];
        // Of a costume's piece, what it lies on tells, be the piece whole or a sleeve.
        const bool lies_far =
            !patch.below.empty() && std::ranges::all_of(patch.below, [&](const auto& each) {
              return steps_between(each.first, node) >= kFarJoints;
            });
        const std::map<int, Index>& amid = patch.is_shell || lies_far ? patch.below : patch.around;
        if (static_cast<std::ptrdiff_t>(k) == area || amid.empty() ||
            static_cast<double>(patch.places.size()) < kPatchPlaces)
          continue;
        const int rival =
            std::ranges::max_element(amid, {}, [](const auto& each) { return each.second; })->first;
        const double steps = steps_between(rival, node);
        const double distance = off(cells, patch);
        const bool vertebra = node == anatomy_.spine.front() || on_torso(node);
        bool asked =
            steps >= kFarJoints ? !vertebra || on_torso(rival) : !vertebra && on_torso(rival);
        double near = kIsland;
        if (patch.is_shell || lies_far) {
          asked = lies_far;
          near = kFar;
        }
        if (!asked || steps < kHumpJoints || distance < near * size_) continue;
        for (const Index p : patch.places) add(out, node, rival, weight_at(p, node), distance, p);
      }
    }
  }

  /// A joint and its image that each weigh what the other should: the middle of each one's weight
  /// lies on the other side than the joint stands. Nothing tells them by their areas, for these are
  /// swapped, too.
  void find_swapped(std::map<int, WeightFault>& wrong) {
    constexpr double kAside = 0.03, kAcrossBy = 0.5;
    std::vector<double> middle(total_.size(), 0.0);
    const auto aside = [&](const glm::dvec3& p) {
      return glm::dot(p - mirror_.middle, mirror_.left);
    };
    for (Index p = 0; p < weights_.size(); ++p)
      for (const NodeWeight& w : weights_[p])
        middle[static_cast<Index>(w.node)] +=
            w.weight * aside(point_[p]) / total_[static_cast<Index>(w.node)];
    const auto is_across = [&](int node) {
      const double joint = aside(at(node));
      return total_[static_cast<Index>(node)] > 0.0 && std::abs(joint) > kAside * size_ &&
             middle[static_cast<Index>(node)] * joint < -kAcrossBy * joint * joint;
    };
    const auto swapped = [&](int node) {
      const int image = image_[static_cast<Index>(node)];
      return image != node && is_across(node) && is_across(image);
    };
    for (Index p = 0; p < weights_.size(); ++p)
      for (const NodeWeight& w : weights_[p])
        if (w.weight >= kCounts && swapped(w.node) && aside(point_[p]) * aside(at(w.node)) < 0.0)
          add(wrong, w.node, image_[static_cast<Index>(w.node)], w.weight,
              glm::distance(point_[p], at(w.node)), p);
  }

  void find_distant(WeightFaults& out) {
    std::map<int, WeightFault> wrong, far, wide, cut_off, heavy_wrong, heavy;
    const std::vector<bool> stays_behind = find_behind(out.far);
    const bool is_fine = point_.size() >= kLeastForSlopes;
    const double far_away = kFar * size_;
    bool sided = false;
    for (Index n = 0; n < image_.size(); ++n)
      sided |= total_[n] > 0.0 && image_[n] != static_cast<int>(n);
    for (Index p = 0; p < weights_.size(); ++p) {
      const double aside = glm::dot(point_[p] - mirror_.middle, mirror_.left);
      for (const NodeWeight& w : weights_[p]) {
        if (w.weight < kCounts) continue;
        const int rival = heaviest_but(p, w.node);
        if (rival < 0) continue;
        const int image = image_[static_cast<Index>(w.node)];
        const double joint_aside = glm::dot(at(w.node) - mirror_.middle, mirror_.left);
        // Legs stand closer together than arms: what is as far out as they are is theirs.
        const double off_middle = std::min(kOffMiddle * size_, kAsFarOut * std::abs(joint_aside));
        const bool other_side =
            image != w.node && joint_aside * aside < 0.0 && std::abs(aside) > off_middle;
        if (stays_behind[static_cast<Index>(w.node)] && is_vertebra(rival)) continue;
        const double steps = steps_between(rival, w.node);
        const bool distant = steps >= kFarJoints;
        if (!other_side && steps < kHumpJoints) continue;
        double distance = distance_to_area(w.node, point_[p], far_away);
        // A long body's legs stand nearer to each other than a share of its length, and from the
        // knees and elbows on they have no surface in common.
        const double across = lower_limb(w.node)
                                  ? std::min(kOffMiddle * size_, kAcross * std::abs(joint_aside))
                                  : kOffMiddle * size_;
        const bool is_wrong = other_side && distance > across;
        // Vertebrae share the surface with legs and with each other: islands of one are no spilt
        // weight, and where one of many weighs more is not plain.
        const bool vertebra = w.node == anatomy_.spine.front() || on_torso(w.node);
        // Next to each other limbs and helpers (hip bones) may have two areas.
        const bool asked = distant ? !vertebra || on_torso(rival) : !vertebra && on_torso(rival);
        const Hump hump = asked ? hump_at(w.node, p) : Hump::none;
        const bool alone =
            !is_wrong && asked && distance > kIsland * size_ && !holds_shell(w.node, p) &&
            (hump == Hump::small || ((distant || (distance >= far_away && steps >= kLedJoints)) &&
                                     (hump == Hump::leads || stands_alone(w.node, p))));
        if (!is_wrong && !alone && !(distant && distance >= far_away)) continue;
        // A wide hump's slope has twice the weight near by, on the hump itself: from there what
        // weighs twice its peak counts.
        if (is_fine && alone && distant && hump == Hump::small) {
          const double off = distance_to_double(w.node, hump_peak_[w.node][p], point_[p]);
          if (off >= kIsland * size_) add(wide, w.node, rival, w.weight, off, p);
        }
        distance = distance_to_double(w.node, w.weight, point_[p]);
        if (is_wrong && distance > across) {
          add(wrong, w.node, image, w.weight, distance, p);
          if (w.weight >= kHeavy) add(heavy_wrong, w.node, image, w.weight, distance, p);
        } else if (!is_wrong && distance >= (alone ? kIsland : kSpilt) * size_) {
          add(far, w.node, rival, w.weight, distance, p);
          if (w.weight >= kHeavy) add(heavy, w.node, rival, w.weight, distance, p);
        }
      }
    }
    if (!sided) out.wrong_side.not_applicable = "no joint with weight has one on the other side";
    find_swapped(wrong);
    keep_patches(wrong);
    keep_patches(far);
    keep_patches(wide, kPlacesUneven, kWidePatch);
    find_cut_off(cut_off);
    keep_patches(cut_off, kPatchPlaces, 0.0);
    keep_patches(heavy_wrong, kPlacesHeavy, 0.0);
    keep_patches(heavy, kPlacesHeavy, 0.0);
    wrong.insert(heavy_wrong.begin(), heavy_wrong.end());
    for (const auto* more : {&wide, &cut_off, &heavy}) far.insert(more->begin(), more->end());
    take(wrong, out.wrong_side);
    take(far, out.far);
  }

  /// Spine or arms: what the spine's motion shows. Feet, fingers, tails and ears of many a healthy
  /// character differ.
  bool is_upper_body(int node) const {
    const auto on = [&](const std::vector<int>& chain, Index count) {
      const auto end = chain.begin() + static_cast<std::ptrdiff_t>(std::min(count, chain.size()));
      return std::find(chain.begin(), end, node) != end;
    };
    return on(anatomy_.spine, anatomy_.spine.size()) || on(anatomy_.left_arm, kArmJoints) ||
           on(anatomy_.right_arm, kArmJoints);
  }

  /// The weights of the surface where each place's mirror image is: of the place there, else of the
  /// nearest point of the triangles around the nearest places. Empty where the surface is too far
  /// off: the body has no other side there. Counts those with a place.
  const std::vector<PlaceWeights>& weights_of_images() {
    if (!images_.empty()) return images_;
    if (edges_.of.empty()) list_edges();
    double length = 0.0;
    for (Index p = 0; p < point_.size(); ++p)
      for (Index e = edges_.first[p]; e < edges_.first[p + 1]; ++e)
        length += glm::distance(point_[p], point_[edges_.of[e]]);
    const double mean_edge =
        edges_.of.empty() ? 0.0 : length / static_cast<double>(edges_.of.size());
    const PointCells cells(point_, std::max(kMirrorSlack * size_, mean_edge));
    std::vector<std::vector<Index>> triangles(point_.size());
    for (Index t = 0; t < character_.triangles.size(); ++t)
      for (int k = 0; k < 3; ++k)
        triangles[character_.place[character_.triangles[t][k]]].push_back(t);
    std::vector<PlaceWeights>& out = images_;
    out.resize(point_.size());
    for (Index p = 0; p < point_.size(); ++p) {
      const glm::dvec3 at = mirror_(point_[p]);
      const Index nearest = cells.nearest(at);
      if (nearest == point_.size()) continue;
      if (const double off = glm::distance(point_[nearest], at); off <= kMirrorSlack * size_) {
        // Where shells touch, several places lie there: this one's image is the one most like it.
        double least = std::numeric_limits<double>::infinity();
        cells.each_within(at, off + kSamePlace * size_, [&](Index q) {
          const double unlike = difference(weights_[p], weights_[q], &image_).share;
          if (unlike >= least) return;
          least = unlike;
          out[p] = weights_[q];
        });
        ++images_by_place_;
        continue;
      }
      TrianglePoint best;
      best.distance = kSurfaceSlack * size_;
      const glm::uvec3* found = nullptr;
      const auto look_around = [&](Index place) {
        for (const Index t : triangles[place]) {
          const glm::uvec3& corner = character_.triangles[t];
          const auto corner_at = [&](int k) { return point_[character_.place[corner[k]]]; };
          const TrianglePoint on =
              closest_on_triangle(at, corner_at(0), corner_at(1), corner_at(2));
          if (on.distance >= best.distance) continue;
          best = on;
          found = &corner;
        }
      };
      look_around(nearest);
      for (Index e = edges_.first[nearest]; e < edges_.first[nearest + 1]; ++e)
        look_around(edges_.of[e]);
      if (found == nullptr) continue;
      std::map<int, double> mixed;
      for (int k = 0; k < 3; ++k)
        for (const NodeWeight& w : weights_[character_.place[(*found)[k]]])
          mixed[w.node] += best.share[static_cast<Index>(k)] * w.weight;
      for (const auto& [node, weight] : mixed) out[p].push_back({node, weight});
    }
    return out;
  }

  /// The share of the places that have a mirror image.
  double mirrored_share() {
    const std::vector<PlaceWeights>& image = weights_of_images();
    return static_cast<double>(
               std::count_if(image.begin(), image.end(),
                             [](const PlaceWeights& each) { return !each.empty(); })) /
           static_cast<double>(point_.size());
  }

  /// Patches of the torso where a weight, of a joint two or more away, rises again and that the
  /// other side has nowhere near: of a body that mirrors itself and whose torso is painted so
  /// elsewhere.
  void find_one_sided(WeightAnswer& out) {
    if (mirrored_share() < kMirrored) return;
    const std::vector<PlaceWeights>& image = weights_of_images();
    const double near = kNearImage * size_;
    const PointCells cells(point_, near);
    // Of joints at one place, such as the two sides' at the hips, each is the other's image.
    std::map<int, std::vector<int>> images;
    const auto images_of = [&](int node) -> const std::vector<int>& {
      const auto [found, is_new] = images.insert({node, {}});
      for (Index n = 0; is_new && n < total_.size(); ++n)
        if (glm::distance(mirror_(at(node)), at(static_cast<int>(n))) <= kJointSlack * size_)
          found->second.push_back(static_cast<int>(n));
      return found->second;
    };
    std::map<int, WeightFault> faults;
    std::map<int, std::vector<Index>> places;
    std::map<int, Index> risen;  // of these places
    std::vector<bool> differs(weights_.size(), false);
    Index torso = 0;
    for (Index p = 0; p < weights_.size(); ++p) {
      if (weights_[p].empty() || image[p].empty() || !on_torso(main_[p])) continue;
      ++torso;
      for (const NodeWeight& w : weights_[p]) {
        const std::vector<int>& others = images_of(w.node);
        if (w.weight < kCounts || others.empty()) continue;
        double there = 0.0;
        const auto look = [&](Index q) {
          double sum = 0.0;
          for (const NodeWeight& each : image[q])
            if (std::find(others.begin(), others.end(), each.node) != others.end())
              sum += each.weight;
          there = std::max(there, sum);
        };
        look(p);
        // The sides' vertices and triangles need not be the same: what is near may have it.
        for (Index e = edges_.first[p]; e < edges_.first[p + 1] && there < w.weight; ++e)
          look(edges_.of[e]);
        if (there < w.weight) cells.each_within(point_[p], near, look);
        const double excess = w.weight - there;
        if (excess > kDiffers) differs[p] = true;
        if (excess < kCounts) continue;
        const int rival = heaviest_but(p, w.node);
        if (rival < 0 || steps_between(rival, w.node) < kHumpJoints) continue;
        add(faults, w.node, rival, excess, glm::distance(at(w.node), point_[p]), p);
        places[w.node].push_back(p);
        risen[w.node] += hump_at(w.node, p) != Hump::none;
      }
    }
    // One side's wider brush fades from the joint's area; what was spilt rises again.
    std::erase_if(faults, [&](const auto& each) {
      return each.second.value < kLeastOneSided || risen[each.first] < kPlacesRisen;
    });
    // One that is a hump nearly everywhere may be smaller; and larger, where another is how that
    // torso is.
    std::erase_if(faults, [&](const auto& each) {
      const auto count = static_cast<double>(each.second.places);
      const bool all_risen = static_cast<double>(risen[each.first]) >= kMostlyRisen * count;
      const double least =
          all_risen ? std::max(kPatchPlaces, kSmallPatch * static_cast<double>(point_.size()))
                    : std::max(kPlacesOneSided, kPatch * static_cast<double>(point_.size()));
      const double most = all_risen ? kMostOfTorsoRisen : kMostOfTorso;
      return count < least || count > most * static_cast<double>(torso);
    });
    for (const auto& each : faults)
      for (const Index p : places[each.first]) differs[p] = false;
    const auto uneven = std::count(differs.begin(), differs.end(), true);
    if (static_cast<double>(uneven) > kUnevenTorso * static_cast<double>(torso)) return;
    for (const WeightFault& each : out.faults) faults.erase(each.node);
    take(faults, out);
  }

  void find_asymmetry(WeightAnswer& out, WeightAnswer& wrong_side) {
    // The skeleton first.
    for (Index n = 0; n < image_.size(); ++n) {
      if (!(total_[n] > kLeastArea * all_)) continue;
      const int node = static_cast<int>(n);
      if (glm::distance(mirror_(at(node)), at(image_[n])) > kJointSlack * size_) {
        out.not_applicable = "the skeleton is not symmetric: joint " +
                             in_quotes(character_.nodes[n].name) + " has no mirror image";
        return;
      }
    }
    const std::vector<PlaceWeights>& image = weights_of_images();
    const double share = mirrored_share();
    if (share < kMirrored) {
      out.not_applicable = "the body is not symmetric: " + number_text(100.0 * share, 3) +
                           " % of its places have a mirror image, " +
                           number_text(100.0 * kMirrored, 3) + " % are needed";
      return;
    }
    // Of each joint, what its side lacks of the other side's weight; a middle joint has two sides.
    std::map<std::pair<int, bool>, WeightFault> faults;
    std::map<std::pair<int, bool>, double> whole, lacks;
    std::map<std::pair<int, bool>, std::map<int, double>> instead;
    std::map<std::pair<int, bool>, double> worst;
    std::map<int, WeightFault> swapped;  // what one side's joint has of the other's
    std::map<int, double> worst_swapped;
    for (Index p = 0; p < point_.size(); ++p) {
      if (weights_[p].empty() || image[p].empty()) continue;
      const bool left = glm::dot(point_[p] - mirror_.middle, mirror_.left) > 0.0;
      // What this place should have, by its image.
      for (const NodeWeight& w : image[p])
        whole[{image_[static_cast<Index>(w.node)], left}] += w.weight;
      const Difference apart = difference(image[p], weights_[p], &image_);
      if (apart.share < kCounts || !is_upper_body(apart.least)) continue;
      const std::pair<int, bool> key(apart.least, left);
      lacks[key] += apart.share;
      const double joint_aside = glm::dot(at(apart.most) - mirror_.middle, mirror_.left);
      if (apart.most == image_[static_cast<Index>(apart.least)] && apart.most != apart.least &&
          (joint_aside > 0.0) != left) {
        WeightFault& wrong = swapped[apart.most];
        wrong.node = apart.most;
        wrong.other = apart.least;
        ++wrong.places;
        wrong.vertices.push_back(vertex_[p]);
        wrong.value +=
            2.0 * apart.share /
            (total_[static_cast<Index>(apart.most)] + total_[static_cast<Index>(apart.least)]);
        if (apart.share > worst_swapped[apart.most]) wrong.vertex = vertex_[p];
        worst_swapped[apart.most] = std::max(worst_swapped[apart.most], apart.share);
      }
      instead[key][apart.most] += apart.share;
      WeightFault& fault = faults[key];
      ++fault.places;
      fault.vertices.push_back(vertex_[p]);
      if (apart.share <= worst[key]) continue;
      worst[key] = apart.share;
      fault.vertex = vertex_[p];
    }
    std::map<int, WeightFault> by_joint;
    // Sides that are not built alike were painted one by one, and are never quite alike.
    const bool unlike =
        static_cast<double>(images_by_place_) < kMirrored * static_cast<double>(point_.size());
    for (auto& [key, fault] : faults) {
      fault.node = key.first;
      const int image_of = image_[static_cast<Index>(key.first)];
      const double all = image_of == key.first ? whole[key] : total_[static_cast<Index>(image_of)];
      if (unlike && all < kLeastUnlike * all_) continue;
      fault.value = std::min(1.0, lacks[key] / std::max(all, 1e-300));
      fault.other =
          std::max_element(instead[key].begin(), instead[key].end(),
                           [](const auto& x, const auto& y) { return x.second < y.second; })
              ->first;
      if (WeightFault& known = by_joint[key.first]; fault.value > known.value) known = fault;
    }
    keep_patches(by_joint);
    if (unlike)
      std::erase_if(by_joint, [](const auto& each) { return each.second.value < kUnlikeSides; });
    take(by_joint, out);
    keep_patches(swapped);
    for (const WeightFault& known : wrong_side.faults) swapped.erase(known.node);
    take(swapped, wrong_side);
  }

  /// Where along the chain the weights of joint k and of those above it begin, as an arc length:
  /// the cut that leaves least weight on its wrong side, over the places that the spine moves.
  double border_at(Index k) const {
    std::vector<std::pair<double, double>> places;  // along the chain, share of k and above
    double wrong = 0.0;                             // of a cut below all places
    for (Index p = 0; p < weights_.size(); ++p) {
      double above = 0.0, all = 0.0;
      for (const NodeWeight& w : weights_[p]) {
        const int on = place_on_spine_[static_cast<Index>(w.node)];
        if (on < 0) continue;
        all += w.weight;
        if (static_cast<Index>(on) >= k) above += w.weight;
      }
      if (all < kMostly) continue;
      places.emplace_back(along_[p], above / all);
      wrong += 1.0 - above / all;
    }
    std::sort(places.begin(), places.end());
    double least = wrong, border = 0.0;
    for (const auto& [along, above] : places) {
      wrong += 2.0 * above - 1.0;
      if (wrong < least) {
        least = wrong;
        border = along;
      }
    }
    return border;
  }

  /// Vertebrae smeared wholly into a neighbour: they have no weight left that could be out of
  /// order, but the weights above (or their own) then begin a bone away from where they should. Not
  /// asked of the joint after the hips, whose own area many a body lets begin behind the chain.
  void find_borders(WeightAnswer& out) const {
    for (Index k = 2; k <= anatomy_.chest_index && k + 1 < chain_.size(); ++k) {
      const double off = border_at(k) - arc_[k];
      const double bone = off < 0.0 ? arc_[k] - arc_[k - 1] : arc_[k + 1] - arc_[k];
      const auto smeared = static_cast<Index>(anatomy_.spine[off < 0.0 ? k - 1 : k]);
      if (total_[smeared] > kNothing * total_[static_cast<Index>(anatomy_.spine[k + 1])]) continue;
      if (std::abs(off) < kOffBone * bone || std::abs(off) > kOffBoneMost * bone ||
          bone < kLongBone * half_width_)
        continue;
      WeightFault fault;
      fault.node = fault.other = anatomy_.spine[k];
      fault.value = std::abs(off) / arc_.back();
      fault.distance = std::abs(off);
      out.faults.push_back(fault);
    }
  }

  void find_order(WeightAnswer& out) {
    const double length = arc_.back();
    if (!(length > 0.0)) return;
    std::vector<double> weight(chain_.size(), 0.0), along(chain_.size(), 0.0),
        beside(chain_.size(), 0.0), leads(chain_.size(), 0.0);
    for (Index p = 0; p < weights_.size(); ++p)
      for (const NodeWeight& w : weights_[p]) {
        if (place_on_spine_[static_cast<Index>(w.node)] < 0) continue;
        const auto k = static_cast<Index>(place_on_spine_[static_cast<Index>(w.node)]);
        weight[k] += w.weight;
        if (main_[p] == w.node) leads[k] += w.weight;
        along[k] += w.weight * along_[p];
        beside[k] += w.weight * beside_[p];
      }
    std::vector<Index> lower;  // joints with an area, from the hips up
    bool asked = false;
    for (Index k = 0; k <= anatomy_.chest_index; ++k) {
      if (weight[k] < kLeastArea * all_ || leads[k] < kLeads * weight[k]) continue;
      // Of joints that stand nearer to each other than the torso is thick, where the surface lies
      // says nothing: the next one down that stands far enough off is asked.
      const auto far_enough = std::find_if(lower.rbegin(), lower.rend(), [&](Index b) {
        const double half_width = (beside[b] + beside[k]) / (weight[b] + weight[k]);
        return arc_[k] - arc_[b] >= kApartInOrder * half_width;
      });
      const bool found = far_enough != lower.rend();
      const Index b = found ? *far_enough : k;
      lower.push_back(k);
      if (!found) continue;
      asked = true;
      const double back = along[b] / weight[b] - along[k] / weight[k];
      // What overlaps by less than joints that were swapped do is a matter of the body's form.
      if (!(back > kOverlaps * (arc_[k] - arc_[b]))) continue;
      WeightFault fault;
      fault.node = anatomy_.spine[b];
      fault.other = anatomy_.spine[k];
      fault.value = back / length;
      fault.distance = back;
      out.faults.push_back(fault);
    }
    if (!asked && lower.size() > 1)
      out.not_applicable =
          "the joints of the spine stand nearer to each other than a fifth of "
          "the torso's width";
    find_borders(out);
    std::stable_sort(out.faults.begin(), out.faults.end(),
                     [](const WeightFault& a, const WeightFault& b) { return a.value > b.value; });
  }

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
    std::vector<bool> out(weights_.size(), false);
    for (std::size_t i = 0, next = 0; i < edges.size(); i = next) {
      for (next = i; next < edges.size() && edges[next] == edges[i];) ++next;
      if (next - i == 1) out[edges[i].first] = out[edges[i].second] = true;
    }
    return out;
  }

  /// Whether a part is a prop: moved by one joint off the spine that moves nothing else and has no
  /// joint with weight below it.
  bool is_prop(const Part& part) const {
    const Index end = part.first_vertex + part.vertex_count;
    int node = -1;
    for (Index v = part.first_vertex; v < end; ++v) {
      const Influences& influences = character_.influences[v];
      const int own = character_.joints[influences.joint[0]].node;
      if (influences.weight[1] > 0.0f || (node >= 0 && own != node)) return false;
      node = own;
    }
    if (node < 0 || place_on_spine_[static_cast<Index>(node)] >= 0) return false;
    for (Index n = 0; n < character_.nodes.size(); ++n)
      if (character_.nodes[n].parent == node && total_[n] > 0.0) return false;
    for (Index v = 0; v < character_.vertex_count(); ++v) {
      if (v >= part.first_vertex && v < end) continue;
      const Influences& influences = character_.influences[v];
      for (Index k = 0; k < kMaxInfluences && influences.weight[k] > 0.0f; ++k)
        if (character_.joints[influences.joint[k]].node == node) return false;
    }
    return true;
  }

  /// The places of the triangles around each place.
  void find_fans() {
    fans_.resize(weights_.size());
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
        ends_[part] = is_prop(character_.parts[part]) ? std::vector<bool>(weights_.size(), false)
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

  void find_seams(WeightAnswer& out) {
    std::map<int, WeightFault> faults;
    // Of each place with several surfaces, the first vertex of each after the first surface's.
    std::map<Index, std::vector<Index>> others;
    for (Index v = 0; v < character_.vertex_count(); ++v) {
      const Index p = character_.place[v];
      if (vertex_[p] == v || weights_[p].empty()) continue;
      const PlaceWeights own = weights_of(character_, v);
      Difference apart = difference(weights_[p], own, nullptr);
      if (apart.share < kCounts) continue;
      if (!is_joined(vertex_[p], v)) {
        std::vector<Index>& first = others[p];
        const auto joined = std::ranges::find_if(first, [&](Index u) { return is_joined(u, v); });
        if (joined == first.end()) {
          first.push_back(v);
          continue;
        }
        apart = difference(weights_of(character_, *joined), own, nullptr);
        if (apart.share < kCounts) continue;
      }
      // No motion of the spine parts eyelids from eyes.
      if (on_head(apart.most) && on_head(apart.least)) continue;
      add(faults, apart.most, apart.least, apart.share, 0.0, p);
    }
    take(faults, out);
  }

  const Character& character_;
  const Anatomy& anatomy_;
  const Mirror mirror_;
  std::vector<std::uint32_t> vertex_;      // the first of each place
  std::vector<glm::dvec3> point_;          // of each place, at rest
  std::vector<PlaceWeights> weights_;      // of each place; none where it came without
  std::vector<int> main_;                  // the node that weighs most
  std::vector<double> total_;              // weight of each node, in places
  std::vector<int> parent_;                // of each node; of a loose joint what it goes with
  std::vector<int> image_;                 // of each node: the one on the other side
  std::vector<int> place_on_spine_;        // of each node: index into the spine; -1 for none
  std::vector<glm::dvec3> chain_;          // the spine's joints
  std::vector<double> arc_;                // ... and their places along it
  std::vector<double> along_, beside_;     // of each place that the spine moves: along it, off it
  std::vector<Index> shell_, shell_size_;  // of each place, and its count of places
  Index largest_shell_ = 0;
  std::vector<PlaceWeights> images_;        // of the surface where each place's mirror image is
  Index images_by_place_ = 0;               // ... of a place there
  std::map<int, std::vector<Index>> held_;  // of each shell: places that a joint weighs
  Neighbours edges_, linked_;               // along the surface; and from shell to shell, too
  /// Of each part, by place: where its surface ends. A prop's ends nowhere.
  std::vector<std::vector<bool>> ends_;
  /// A triangle at a place: its vertex there, and the places of the other two.
  struct Corner {
    Index vertex;
    std::array<Index, 2> others;
  };
  std::vector<std::vector<Corner>> fans_;  // of each place; made when first asked
  std::map<int, std::vector<bool>> island_;
  std::map<int, std::vector<Hump>> hump_;
  std::map<int, std::vector<double>> hump_peak_;  // the weight at the peak of each place's hump
  std::map<int, std::unique_ptr<PointCells>> area_;
  std::map<int, std::vector<std::pair<double, Index>>> places_of_;  // weight and place, by node
  double all_ = 0.0;
  double size_ = 0.0;        // the body's largest side
  double half_width_ = 0.0;  // of the torso, from the chain to the surface
  double spine_step_ = 1.0;  // as far along the spine counts as one joint of another chain
};

}  // namespace

WeightFaults find_weight_faults(const Character& character, const Anatomy& anatomy) {
  WeightFaults out = FaultFinder(character, anatomy).find();
  out.borders = find_hard_borders(character, anatomy);
  return out;
}

std::string place_of_fault(const Character& character, const Anatomy& anatomy,
                           const WeightFault& fault) {
  if (fault.places == 0) return "";
  const Region region = vertex_regions(character, anatomy)[fault.vertex];
  for (const Part& part : character.parts)
    if (fault.vertex >= part.first_vertex && fault.vertex < part.first_vertex + part.vertex_count)
      return std::string(region_name(region)) + " of part " + in_quotes(part.name);
  return std::string(region_name(region));
}

std::vector<std::string> weight_fault_lines(const Character& character, const Anatomy& anatomy) {
  const WeightFaults faults = find_weight_faults(character, anatomy);
  const auto name = [&](int node) {
    return in_quotes(character.nodes[static_cast<Index>(node)].name);
  };
  const auto percent = [](double share) { return number_text(100.0 * share, 3) + " %"; };
  std::vector<std::string> out;
  const auto add = [&](const char* what, const WeightAnswer& answer) {
    std::string line = std::string(what) + ": ";
    if (!answer.not_applicable.empty()) {
      out.push_back(line + "not applicable, " + answer.not_applicable);
      return;
    }
    if (answer.faults.empty()) {
      out.push_back(line + "none");
      return;
    }
    const WeightFault& worst = answer.faults.front();
    line += name(worst.node) + " " + percent(worst.value);
    if (worst.other >= 0) line += ", where " + name(worst.other) + " is";
    if (worst.places > 0)
      line += " (" + plural(worst.places, "place") + ", " +
              place_of_fault(character, anatomy, worst) + ", vertex " +
              std::to_string(worst.vertex) + ")";
    if (answer.faults.size() > 1)
      line += "; " + plural(answer.faults.size() - 1, "joint") + " more";
    out.push_back(line);
  };
  add("on the other side", faults.wrong_side);
  add("far from its area", faults.far);
  add("left against right", faults.asymmetry);
  add("out of order along the spine", faults.order);
  add("different at one place", faults.seams);
  add("hard border between vertebrae", faults.borders);
  for (const JointBindOff& off : joints_bound_off(character))
    out.push_back("bind pose: " + name(off.node) + " is bound " + number_text(off.angle_deg, 3) +
                  " deg off, its surface stands up to " + number_text(off.shift, 3) + " off");
  return out;
}

}  // namespace backbend::skin
