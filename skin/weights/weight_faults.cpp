#include "skin/weights/weight_faults.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <map>
#include <memory>

#include "skin/anatomy/import_checks.h"
#include "skin/character/point_cells.h"
#include "skin/character/printable.h"
#include "skin/weights/body_sides.h"
#include "skin/weights/costume_pieces.h"
#include "skin/weights/fault_map.h"
#include "skin/weights/skin_places.h"
#include "skin/weights/weight_asymmetry.h"
#include "skin/weights/weight_borders.h"
#include "skin/weights/weight_levels.h"
#include "skin/weights/weight_order.h"
#include "skin/weights/weight_seams.h"

namespace backbend::skin {
namespace {

using Index = std::size_t;

// Lengths are shares of the body's largest side.
constexpr double kOffMiddle = 0.12;    // nearer the middle both sides share vertices
constexpr double kAsFarOut = 0.6;      // ... or further out than this share of the joint's own
constexpr double kAcross = 0.9;        // ... of the joint's own, from its area
constexpr double kFar = 0.15;          // from a joint's area
constexpr double kSpilt = 0.2;         // a weight that fades halves within less
constexpr double kIsland = 0.08;       // ... and one that stands alone needs no more
constexpr double kPiece = 0.05;        // of the places: a piece of costume, bound as a whole
constexpr std::size_t kArmJoints = 2;  // of an arm: clavicle and upper arm
constexpr double kHumpJoints = 2.0;    // along the skeleton, for a weight that rises again
constexpr double kLedJoints = 2.5;     // ... and leads there, as far off as kFar
constexpr double kWhole = 0.95;        // of a joint's largest weight: as much as anywhere
constexpr double kHump = 0.04;         // of a vertex's weight: how far it rises
constexpr double kMostly = 0.5;        // of a weight, for its joint to lead
constexpr double kJointSlack = 0.01;   // between a joint and its image
constexpr double kPatch = 0.005;       // of the places, and ...
constexpr double kWidePatch = 0.01;    // ... of a hump with its slope
constexpr std::size_t kLeastForSlopes = 1000;  // places: on fewer a joint's area is all slope
constexpr double kPatchPlaces = 6.0;           // ... this many: fewer are single slips
constexpr double kHeavy = 0.2;                 // of a vertex's weight: few places show it, ...
constexpr double kPlacesHeavy = 4.0;           // ... and fewer are slips
constexpr double kSure = 0.6;                  // ... but for this much, which no smoothing leaves
constexpr double kPlacesSure = 2.0;
constexpr double kPlacesBehind = 24.0;     // of a joint above the hips: low bodies leave it a few
constexpr double kShareBehind = 0.02;      // ... and of all places
constexpr double kHeldBehind = 0.08;       // of a vertex's weight: it is held back in plain sight
constexpr double kHeldAround = 0.05;       // ... and so much
constexpr double kPlacesHeld = 12.0;       // ... on these many places
constexpr double kShareHeld = 0.009;       // ... and of all
constexpr double kHeldStrongly = 0.1;      // of a vertex's weight, ...
constexpr double kShareOfTorso = 0.08;     // ... on so much of the torso's places, 12 at least
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

class FaultFinder {
 public:
  FaultFinder(const Character& character, const Anatomy& anatomy)
      : character_(character),
        anatomy_(anatomy),
        places_(character, anatomy),
        sides_(character, anatomy, places_) {}

  WeightFaults find() {
    WeightFaults out;
    if (!(places_.size > 0.0) || !(places_.all > 0.0)) return out;
    find_distant(out);
    find_one_sided(out.far);
    find_asymmetry(places_, sides_, out.asymmetry, out.wrong_side);
    out.order = find_order_faults(character_, places_, anatomy_);
    out.levels = find_level_faults(places_, anatomy_);
    out.seams = find_seam_faults(character_, anatomy_, places_);
    return out;
  }

 private:
  /// The area of a joint: places where it weighs most, of one that hardly does those where it
  /// weighs at least half as much as anywhere; and its bone.
  double distance_to_area(int node, const glm::dvec3& point, double enough) {
    auto& cells = area_[node];
    if (!cells) {
      std::vector<glm::dvec3> points;
      const double half = 0.5 * largest_weight(node);
      const bool leads =
          half >= 0.5 * kMostly &&
          std::find(places_.main.begin(), places_.main.end(), node) != places_.main.end();
      for (Index p = 0; p < places_.main.size(); ++p)
        if (leads ? places_.main[p] == node && hump_at(node, p) != Hump::leads
                  : half > 0.0 && places_.weight_at(p, node) >= half &&
                        hump_at(node, p) == Hump::none)
          points.push_back(places_.point[p]);
      for (const glm::dvec3& on_bone : places_.points_on_bones(node)) points.push_back(on_bone);
      cells = std::make_unique<PointCells>(std::move(points), kFar * places_.size);
    }
    const Index nearest = cells->nearest(point);
    return nearest == cells->size() ? enough : glm::distance(cells->point(nearest), point);
  }

  /// Whether no edges lead from a place to the joint's area over places that it weighs, too. On
  /// another shell, a costume's, it has an area of its own.
  bool stands_alone(int node, Index place) {
    auto& island = island_[node];
    if (island.empty()) {
      island.assign(places_.weights.size(), false);
      std::vector<bool> has(places_.weights.size(), false);
      std::vector<Index> pending;
      for (Index p = 0; p < places_.weights.size(); ++p)
        for (const NodeWeight& w : places_.weights[p])
          if (w.node == node && w.weight >= kCounts) has[p] = true;
      // From all places where it weighs most: what is not reached stands alone. A joint that weighs
      // most nowhere has its area where it weighs at least half as much as anywhere.
      const bool leads =
          std::find(places_.main.begin(), places_.main.end(), node) != places_.main.end();
      const double largest = largest_weight(node);
      std::vector<bool> reached(places_.weights.size(), false);
      for (Index p = 0; p < places_.weights.size(); ++p)
        if (leads ? places_.main[p] == node : places_.weight_at(p, node) >= 0.5 * largest) {
          reached[p] = true;
          pending.push_back(p);
        }
      while (!pending.empty()) {
        const Index p = pending.back();
        pending.pop_back();
        for (Index e = places_.linked.first[p]; e < places_.linked.first[p + 1]; ++e)
          if (has[places_.linked.of[e]] && !reached[places_.linked.of[e]]) {
            reached[places_.linked.of[e]] = true;
            pending.push_back(places_.linked.of[e]);
          }
      }
      for (Index p = 0; p < places_.weights.size(); ++p) island[p] = has[p] && !reached[p];
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
    struct Area {
      Index peak = 0;     // its heaviest place
      double held = 0.0;  // the weight of all
      std::vector<Index> places;
    };
    std::vector<std::pair<double, Index>> order;
    for (Index p = 0; p < places_.weights.size(); ++p)
      if (const double w = places_.weight_at(p, node); w > 0.0) order.emplace_back(-w, p);
    std::sort(order.begin(), order.end());
    std::vector<Area> areas;
    constexpr Index kDry = static_cast<Index>(-1);
    std::vector<Index> area_of(places_.weights.size(), kDry);
    std::vector<Hump> hump(places_.weights.size(), Hump::none);
    std::vector<Index>& peak_of = hump_peak_[node];
    peak_of.assign(places_.weights.size(), 0);
    const auto mark = [&](const Area& area) {
      const bool leads =
          std::ranges::any_of(area.places, [&](Index q) { return places_.main[q] == node; });
      const Hump kind = leads ? Hump::leads : Hump::small;
      for (const Index q : area.places) {
        hump[q] = kind;
        peak_of[q] = area.peak;
      }
    };
    for (const auto& [negative, p] : order) {
      Index own = kDry;
      for (Index e = places_.linked.first[p]; e < places_.linked.first[p + 1]; ++e) {
        const Index other = area_of[places_.linked.of[e]];
        if (other == kDry || other == own) continue;
        if (own == kDry) {
          own = other;
          continue;
        }
        // On a piece of costume weights are as high as one likes (a hat is bound more firmly than
        // the head below it): of peaks on two shells the one with less weight around it.
        const Area &a = areas[own], &b = areas[other];
        const bool own_is_lower =
            places_.shell[a.peak] == places_.shell[b.peak]
                ? places_.weight_at(a.peak, node) < places_.weight_at(b.peak, node)
                : a.held < b.held;
        const Area& lower = areas[own_is_lower ? own : other];
        if (places_.weight_at(lower.peak, node) + negative >= kHump) mark(lower);
        const Index peak = areas[own_is_lower ? other : own].peak;
        // The smaller one's places go over to the larger.
        const bool own_is_smaller = areas[own].places.size() < areas[other].places.size();
        Area& from = areas[own_is_smaller ? own : other];
        own = own_is_smaller ? other : own;
        for (const Index q : from.places) area_of[q] = own;
        areas[own].places.insert(areas[own].places.end(), from.places.begin(), from.places.end());
        areas[own].peak = peak;
        areas[own].held += from.held;
        from.held = 0.0;
        from.places.clear();
      }
      if (own == kDry) {
        own = areas.size();
        areas.push_back({p, 0.0, {}});
      }
      area_of[p] = own;
      areas[own].held -= negative;
      areas[own].places.push_back(p);
    }
    // What no edges join to the joint's own area: the one at its bones that holds most of the
    // weight, for what was spilt may hold more than all of a hand.
    std::erase_if(areas, [](const Area& area) { return area.places.empty(); });
    if (areas.size() < 2) return hump;
    const std::vector<glm::dvec3> bones = places_.points_on_bones(node);
    const auto at_bones = [&](const Area& area) {
      return std::ranges::any_of(area.places, [&](Index q) {
        return std::ranges::any_of(bones, [&](const glm::dvec3& on_bone) {
          return glm::distance(places_.point[q], on_bone) < kIsland * places_.size;
        });
      });
    };
    const auto rank = [&](const Area& area) { return std::pair(at_bones(area), area.held); };
    const Area& own = *std::ranges::max_element(areas, {}, rank);
    for (const Area& area : areas)
      if (&area != &own && places_.weight_at(area.peak, node) >= kHump) mark(area);
    return hump;
  }

  double largest_weight(int node) const {
    double largest = 0.0;
    for (Index p = 0; p < places_.weights.size(); ++p)
      largest = std::max(largest, places_.weight_at(p, node));
    return largest;
  }

  /// Whether a joint weighs on all of a small shell: a piece of costume that was bound so as a
  /// whole.
  bool holds_shell(int node, Index place) {
    const Index shell = places_.shell[place];
    if (shell == places_.largest_shell || static_cast<double>(places_.shell_size[shell]) >
                                              kPiece * static_cast<double>(places_.shell.size()))
      return false;
    auto& held = held_[node];
    if (held.empty()) {
      held.assign(places_.shell_size.size(), 0);
      for (Index p = 0; p < places_.shell.size(); ++p)
        if (places_.weight_at(p, node) >= kCounts) ++held[places_.shell[p]];
    }
    return held[shell] == places_.shell_size[shell];
  }

  /// How far from a place the nearest one is at which a joint weighs twice as much, or, off the
  /// small hump that the place is on, about as much as it does anywhere: short where its weight
  /// fades, long where it was spilt. A hump of a joint that weighs little all over is as heavy as
  /// its area.
  double distance_to_double(int node, double weight, Index place) {
    auto& places = places_of_[node];
    if (places.empty())
      for (Index p = 0; p < places_.weights.size(); ++p)
        for (const NodeWeight& w : places_.weights[p])
          if (w.node == node) places.emplace_back(w.weight, p);
    const bool on_hump = hump_at(node, place) == Hump::small;
    const std::vector<Index>& peak = hump_peak_[node];
    const auto is_off_hump = [&](Index other) {
      return !on_hump || hump_at(node, other) != Hump::small || peak[other] != peak[place];
    };
    double largest = 0.0;
    for (const auto& [w, other] : places)
      if (is_off_hump(other)) largest = std::max(largest, w);
    const glm::dvec3& point = places_.point[place];
    double nearest = glm::distance(places_.at(node), point);
    for (const auto& [w, other] : places)
      if (w >= 2.0 * weight || (w >= kWhole * largest && is_off_hump(other)))
        nearest = std::min(nearest, glm::distance(places_.point[other], point));
    return nearest;
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
    for (Index p = 0; p < places_.main.size(); ++p)
      if (places_.main[p] == node) leads += places_.weight_at(p, node);
    return leads < kFollows * places_.total[static_cast<Index>(node)];
  }

  /// Whether a joint is a vertebra above the hips, up to the chest.
  bool on_torso(int node) const {
    const int on = places_.on_spine[static_cast<Index>(node)];
    return on > 0 && on <= static_cast<int>(anatomy_.chest_index);
  }

  /// Whether a joint is a vertebra above the hips, neck and head among them.
  bool is_vertebra(int node) const { return places_.on_spine[static_cast<Index>(node)] > 0; }

  /// What vertebrae move and a joint above the hips keeps; on few places only where it keeps much,
  /// or where both sides do not have it alike (a belly that was left to the whole body's joint has
  /// it on both). A spine that hangs from its chest has vertebrae above the hips, which do move.
  /// Which joints are meant.
  std::vector<bool> find_behind(WeightAnswer& out) {
    std::vector<bool> meant(places_.total.size(), false);
    for (Index n = 0; n < places_.total.size(); ++n)
      meant[n] = places_.total[n] > 0.0 && places_.on_spine[n] < 0 &&
                 sides_.above_hips(static_cast<int>(n)) && follows(static_cast<int>(n));
    FaultMap all, held, strongly, one_sided;
    for (Index p = 0; p < places_.weights.size(); ++p)
      for (const NodeWeight& w : places_.weights[p]) {
        if (w.weight < kCounts || !meant[static_cast<Index>(w.node)]) continue;
        const int rival = places_.heaviest_but(p, w.node);
        if (rival < 0 || !is_vertebra(rival)) continue;
        const double distance = glm::distance(places_.at(w.node), places_.point[p]);
        add_fault(places_, all, w.node, rival, w.weight, distance, p);
        if (w.weight >= kHeldAround) add_fault(places_, held, w.node, rival, w.weight, distance, p);
        if (w.weight >= kHeldStrongly)
          add_fault(places_, strongly, w.node, rival, w.weight, distance, p);
        double there = 0.0;
        for (const NodeWeight& other : sides_.images()[p])
          if (other.node == w.node) there += other.weight;
        if (there <= kOneSided * w.weight)
          add_fault(places_, one_sided, w.node, rival, w.weight, distance, p);
      }
    FaultMap uneven;
    for (const auto& [node, fault] : all)
      if (const auto side = one_sided.find(node);
          side != one_sided.end() && side->second.places >= kUneven * fault.places)
        uneven.insert({node, fault});
    keep_patches(places_, uneven, kPlacesUneven, kSmallPatch);
    keep_patches(places_, all, kPlacesBehind, kShareBehind);
    keep_patches(places_, held, kPlacesHeld, kShareHeld);
    const auto on_vertebrae =
        std::ranges::count_if(places_.main, [&](int node) { return node >= 0 && on_torso(node); });
    keep_patches(places_, strongly,
                 std::max(kPlacesHeld, kShareOfTorso * static_cast<double>(on_vertebrae)), 0.0);
    std::erase_if(held, [](const auto& each) { return each.second.value < kHeldBehind; });
    for (const auto* more : {&all, &held, &strongly}) uneven.insert(more->begin(), more->end());
    take_faults(uneven, out);
    return meant;
  }

  /// A patch of one shell that one joint moves most.
  struct Patch {
    std::vector<Index> places;
    std::map<int, Index> around;  // edges that lead out of it, by the joint that moves most there
    std::map<int, Index> below;   // what it lies on, of a shell other than the largest: as `around`
  };

  /// The patches of each joint.
  std::map<int, std::vector<Patch>> patches_of_joints() {
    std::map<int, std::vector<Patch>> out;
    std::vector<bool> done(places_.main.size(), false);
    for (Index start = 0; start < places_.main.size(); ++start) {
      if (done[start] || places_.main[start] < 0) continue;
      Patch& patch = out[places_.main[start]].emplace_back();
      patch.places.push_back(start);
      done[start] = true;
      for (Index next = 0; next < patch.places.size(); ++next) {
        const Index p = patch.places[next];
        for (Index e = places_.edges.first[p]; e < places_.edges.first[p + 1]; ++e) {
          const Index q = places_.edges.of[e];
          if (places_.main[q] != places_.main[start]) {
            if (places_.main[q] >= 0) ++patch.around[places_.main[q]];
          } else if (!done[q]) {
            done[q] = true;
            patch.places.push_back(q);
          }
        }
      }
      if (places_.shell[start] == places_.largest_shell) continue;
      for (const Index p : patch.places)
        for (Index e = places_.linked.first[p]; e < places_.linked.first[p + 1]; ++e)
          if (const Index q = places_.linked.of[e];
              places_.shell[q] != places_.shell[p] && places_.main[q] >= 0)
            ++patch.below[places_.main[q]];
    }
    return out;
  }

  /// Whether a patch of few places is one all the same: on the body, and a joint's nearly alone.
  bool is_sure(int node, const Patch& patch) const {
    return static_cast<double>(patch.places.size()) >= kPlacesSure &&
           std::ranges::all_of(patch.places, [&](Index p) {
             return places_.shell[p] == places_.largest_shell &&
                    places_.weight_at(p, node) >= kSure;
           });
  }

  /// Patches far from a joint's bones and from its area there, amid what joints far along the
  /// skeleton move; other joints need not weigh on them. Or, of a piece of costume, where all that
  /// they lie on is so far: gloves and sleeves that were swapped are amid each other's joints.
  void find_cut_off(FaultMap& out) {
    for (const auto& [node, patches] : patches_of_joints()) {
      if (patches.size() < 2) continue;
      std::vector<glm::dvec3> own = places_.points_on_bones(node);
      const PointCells bones(own, kFar * places_.size);
      const auto off = [&](const PointCells& cells, const Patch& patch) {
        double nearest = std::numeric_limits<double>::infinity();
        for (const Index p : patch.places) {
          const Index found = cells.nearest(places_.point[p]);
          // What is further off than the cells reach is told by the joint itself.
          const glm::dvec3 own_place = found < cells.size() ? cells.point(found) : places_.at(node);
          nearest = std::min(nearest, glm::distance(own_place, places_.point[p]));
        }
        return nearest;
      };
      std::vector<double> off_bones;
      for (const Patch& patch : patches) off_bones.push_back(off(bones, patch));
      const auto area = std::min_element(off_bones.begin(), off_bones.end()) - off_bones.begin();
      for (const Index p : patches[static_cast<Index>(area)].places)
        own.push_back(places_.point[p]);
      const PointCells cells(std::move(own), kFar * places_.size);
      for (Index k = 0; k < patches.size(); ++k) {
        const Patch& patch = patches[k];
        // Of a sleeve, what it lies on tells; whole pieces have a question of their own.
        const bool lies_far =
            !patch.below.empty() && std::ranges::all_of(patch.below, [&](const auto& each) {
              return places_.steps_between(each.first, node) >= kFarJoints;
            });
        const std::map<int, Index>& amid = lies_far ? patch.below : patch.around;
        if (static_cast<std::ptrdiff_t>(k) == area || patch.around.empty()) continue;
        const bool is_small = static_cast<double>(patch.places.size()) < kPatchPlaces;
        if (is_small && !is_sure(node, patch)) continue;
        const int rival =
            std::ranges::max_element(amid, {}, [](const auto& each) { return each.second; })->first;
        const double steps = places_.steps_between(rival, node);
        const double distance = off(cells, patch);
        const bool vertebra = node == anatomy_.spine.front() || on_torso(node);
        const bool asked = lies_far || (steps >= kFarJoints ? !vertebra || on_torso(rival)
                                                            : !vertebra && on_torso(rival));
        if (!asked || steps < (is_small ? kFarJoints : kHumpJoints) ||
            distance < (lies_far ? kFar : kIsland) * places_.size)
          continue;
        for (const Index p : patch.places)
          add_fault(places_, out, node, rival, places_.weight_at(p, node), distance, p);
      }
    }
  }

  /// How far to the left of the body's middle.
  double aside(const glm::dvec3& p) const {
    return glm::dot(p - sides_.mirror().middle, sides_.mirror().left);
  }

  /// Of each node: how far to the left the middle of its weight lies; 0 without weight.
  std::vector<double> middles_of_weight() const {
    std::vector<double> out(places_.total.size(), 0.0);
    for (Index p = 0; p < places_.weights.size(); ++p)
      for (const NodeWeight& w : places_.weights[p])
        out[static_cast<Index>(w.node)] +=
            w.weight * aside(places_.point[p]) / places_.total[static_cast<Index>(w.node)];
    return out;
  }

  /// Of each node: how far to the left it belongs. A fin's or a leg's first joint may stand in the
  /// middle, where rounding would choose its side: the next joint below it that does not tells, and
  /// of a last joint its weight.
  std::vector<double> asides_of_joints() const {
    std::vector<double> out = middles_of_weight();
    std::vector<int> steps(out.size(), std::numeric_limits<int>::max());
    const auto parent = [&](int node) { return character_.nodes[static_cast<Index>(node)].parent; };
    const auto is_off_middle = [&](int node) {
      return std::abs(aside(places_.at(node))) > kJointSlack * places_.size;
    };
    for (int node = 0; node < static_cast<int>(out.size()); ++node) {
      if (!is_off_middle(node)) continue;
      const double own = out[static_cast<Index>(node)] = aside(places_.at(node));
      int step = 1;
      for (int above = parent(node); above >= 0 && !is_off_middle(above); above = parent(above)) {
        if (step < steps[static_cast<Index>(above)]) {
          steps[static_cast<Index>(above)] = step;
          out[static_cast<Index>(above)] = own;
        }
        ++step;
      }
    }
    return out;
  }

  /// A joint and its image that each weigh what the other should: the middle of each one's weight
  /// lies on the other side than the joint stands. Nothing tells them by their areas, for these are
  /// swapped, too.
  void find_swapped(const std::vector<double>& asides, FaultMap& wrong) {
    constexpr double kAside = 0.03, kAcrossBy = 0.5;
    const std::vector<double> middle = middles_of_weight();
    const auto is_across = [&](int node) {
      const double joint = asides[static_cast<Index>(node)];
      return places_.total[static_cast<Index>(node)] > 0.0 &&
             std::abs(joint) > kAside * places_.size &&
             middle[static_cast<Index>(node)] * joint < -kAcrossBy * joint * joint;
    };
    const auto swapped = [&](int node) {
      const int image = sides_.joint_images()[static_cast<Index>(node)];
      return image != node && is_across(node) && is_across(image);
    };
    for (Index p = 0; p < places_.weights.size(); ++p)
      for (const NodeWeight& w : places_.weights[p])
        if (w.weight >= kCounts && swapped(w.node) &&
            aside(places_.point[p]) * asides[static_cast<Index>(w.node)] < 0.0)
          add_fault(places_, wrong, w.node, sides_.joint_images()[static_cast<Index>(w.node)],
                    w.weight, glm::distance(places_.point[p], places_.at(w.node)), p);
  }

  void find_distant(WeightFaults& out) {
    FaultMap wrong, far, wide, cut_off, heavy_wrong, heavy, wrong_pieces, pieces;
    const std::vector<bool> stays_behind = find_behind(out.far);
    const bool is_fine = places_.own_count >= kLeastForSlopes;
    const double far_away = kFar * places_.size;
    bool sided = false;
    for (Index n = 0; n < sides_.joint_images().size(); ++n)
      sided |= places_.total[n] > 0.0 && sides_.joint_images()[n] != static_cast<int>(n);
    const std::vector<double> asides = asides_of_joints();
    for (Index p = 0; p < places_.weights.size(); ++p) {
      const double place_aside = aside(places_.point[p]);
      for (const NodeWeight& w : places_.weights[p]) {
        if (w.weight < kCounts) continue;
        const int rival = places_.heaviest_but(p, w.node);
        if (rival < 0) continue;
        const int image = sides_.joint_images()[static_cast<Index>(w.node)];
        const double joint_aside = asides[static_cast<Index>(w.node)];
        // Legs stand closer together than arms: what is as far out as they are is theirs.
        const double off_middle =
            std::min(kOffMiddle * places_.size, kAsFarOut * std::abs(joint_aside));
        const bool other_side = image != w.node && joint_aside * place_aside < 0.0 &&
                                std::abs(place_aside) > off_middle;
        if (stays_behind[static_cast<Index>(w.node)] && is_vertebra(rival)) continue;
        const double steps = places_.steps_between(rival, w.node);
        const bool distant = steps >= kFarJoints;
        if (!other_side && steps < kHumpJoints) continue;
        double distance = distance_to_area(w.node, places_.point[p], far_away);
        // A long body's legs stand nearer to each other than a share of its length, and from the
        // knees and elbows on they have no surface in common.
        const double across = lower_limb(w.node) ? std::min(kOffMiddle * places_.size,
                                                            kAcross * std::abs(joint_aside))
                                                 : kOffMiddle * places_.size;
        const bool is_wrong = other_side && distance > across;
        // Vertebrae share the surface with legs and with each other: islands of one are no spilt
        // weight, and where one of many weighs more is not plain.
        const bool vertebra = w.node == anatomy_.spine.front() || on_torso(w.node);
        // Next to each other limbs and helpers (hip bones) may have two areas.
        const bool asked = distant ? !vertebra || on_torso(rival) : !vertebra && on_torso(rival);
        const Hump hump = asked ? hump_at(w.node, p) : Hump::none;
        const bool alone =
            !is_wrong && asked && distance > kIsland * places_.size && !holds_shell(w.node, p) &&
            (hump == Hump::small || ((distant || (distance >= far_away && steps >= kLedJoints)) &&
                                     (hump == Hump::leads || stands_alone(w.node, p))));
        if (!is_wrong && !alone && !(distant && distance >= far_away)) continue;
        // A wide hump's slope has twice the weight near by, on the hump itself: from there what
        // weighs twice its peak counts.
        if (is_fine && alone && distant && hump == Hump::small) {
          const double peak = places_.weight_at(hump_peak_[w.node][p], w.node);
          const double off = distance_to_double(w.node, peak, p);
          if (off >= kIsland * places_.size)
            add_fault(places_, wide, w.node, rival, w.weight, off, p);
        }
        distance = distance_to_double(w.node, w.weight, p);
        if (is_wrong && distance > across) {
          add_fault(places_, wrong, w.node, image, w.weight, distance, p);
          if (w.weight >= kHeavy)
            add_fault(places_, heavy_wrong, w.node, image, w.weight, distance, p);
        } else if (!is_wrong && distance >= (alone ? kIsland : kSpilt) * places_.size) {
          add_fault(places_, far, w.node, rival, w.weight, distance, p);
          if (w.weight >= kHeavy) add_fault(places_, heavy, w.node, rival, w.weight, distance, p);
        }
      }
    }
    if (!sided) out.wrong_side.not_applicable = "no joint with weight has one on the other side";
    find_swapped(asides, wrong);
    keep_patches(places_, wrong);
    keep_patches(places_, far);
    keep_patches(places_, wide, kPlacesUneven, kWidePatch);
    find_cut_off(cut_off);
    find_misbound_pieces(character_, anatomy_, places_, sides_.mirror(), sides_.joint_images(),
                         wrong_pieces, pieces);
    keep_patches(places_, cut_off, kPlacesSure, 0.0);
    keep_patches(places_, heavy_wrong, kPlacesHeavy, 0.0);
    keep_patches(places_, heavy, kPlacesHeavy, 0.0);
    for (const auto* more : {&heavy_wrong, &wrong_pieces}) wrong.insert(more->begin(), more->end());
    for (const auto* more : {&wide, &cut_off, &heavy, &pieces})
      far.insert(more->begin(), more->end());
    take_faults(wrong, out.wrong_side);
    take_faults(far, out.far);
  }

  /// Patches of the torso where a weight, of a joint two or more away, rises again and that the
  /// other side has nowhere near: of a body that mirrors itself and whose torso is painted so
  /// elsewhere.
  void find_one_sided(WeightAnswer& out) {
    if (!sides_.surface_is_comparable()) return;
    const std::vector<PlaceWeights>& image = sides_.images();
    const double near = kNearImage * places_.size;
    const PointCells cells(places_.point, near);
    // Of joints at one place, such as the two sides' at the hips, each is the other's image.
    std::map<int, std::vector<int>> images;
    const auto images_of = [&](int node) -> const std::vector<int>& {
      const auto [found, is_new] = images.insert({node, {}});
      for (Index n = 0; is_new && n < places_.total.size(); ++n)
        if (glm::distance(sides_.mirror()(places_.at(node)), places_.at(static_cast<int>(n))) <=
            kJointSlack * places_.size)
          found->second.push_back(static_cast<int>(n));
      return found->second;
    };
    FaultMap faults;
    std::map<int, std::vector<Index>> places;
    std::map<int, Index> risen;  // of these places
    std::vector<bool> differs(places_.weights.size(), false);
    Index torso = 0;
    for (Index p = 0; p < places_.weights.size(); ++p) {
      if (places_.weights[p].empty() || image[p].empty() || sides_.is_left_out(p) ||
          !on_torso(places_.main[p]))
        continue;
      ++torso;
      for (const NodeWeight& w : places_.weights[p]) {
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
        for (Index e = places_.edges.first[p]; e < places_.edges.first[p + 1] && there < w.weight;
             ++e)
          look(places_.edges.of[e]);
        if (there < w.weight) cells.each_within(places_.point[p], near, look);
        const double excess = w.weight - there;
        if (excess > kDiffers) differs[p] = true;
        if (excess < kCounts) continue;
        const int rival = places_.heaviest_but(p, w.node);
        if (rival < 0 || places_.steps_between(rival, w.node) < kHumpJoints) continue;
        add_fault(places_, faults, w.node, rival, excess,
                  glm::distance(places_.at(w.node), places_.point[p]), p);
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
          all_risen ? std::max(kPatchPlaces, kSmallPatch * static_cast<double>(places_.own_count))
                    : std::max(kPlacesOneSided, kPatch * static_cast<double>(places_.own_count));
      const double most = all_risen ? kMostOfTorsoRisen : kMostOfTorso;
      return count < least || count > most * static_cast<double>(torso);
    });
    for (const auto& each : faults)
      for (const Index p : places[each.first]) differs[p] = false;
    const auto uneven = std::count(differs.begin(), differs.end(), true);
    if (static_cast<double>(uneven) > kUnevenTorso * static_cast<double>(torso)) return;
    for (const WeightFault& each : out.faults) faults.erase(each.node);
    take_faults(faults, out);
  }

  const Character& character_;
  const Anatomy& anatomy_;
  const SkinPlaces places_;
  const BodySides sides_;
  std::map<int, std::vector<Index>> held_;  // of each shell: places that a joint weighs
  std::map<int, std::vector<bool>> island_;
  std::map<int, std::vector<Hump>> hump_;
  std::map<int, std::vector<Index>> hump_peak_;  // of each place on a hump: the heaviest there
  std::map<int, std::unique_ptr<PointCells>> area_;
  std::map<int, std::vector<std::pair<double, Index>>> places_of_;  // weight and place, by node
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
  add("off their bones along the spine", faults.levels);
  add("different at one place", faults.seams);
  add("hard border between vertebrae", faults.borders);
  for (const JointBindOff& off : joints_bound_off(character))
    out.push_back("bind pose: " + name(off.node) + " is bound " + number_text(off.angle_deg, 3) +
                  " deg off, its surface stands up to " + number_text(off.shift, 3) + " off");
  return out;
}

}  // namespace backbend::skin
