#include "skin/weights/weight_order.h"
#include "skin/character/ancestor.h"

#include <algorithm>
#include <cmath>

namespace backbend::skin {
namespace {

using Index = std::size_t;

constexpr double kLeads = 0.25;        // of a joint's weight, where it weighs most: else no area
constexpr double kOverlaps = 0.3;      // of the way between two joints, for a fault of their order
constexpr double kApartInOrder = 0.4;  // of the torso's half width, for joints to have an order
constexpr double kNothing = 0.02;      // of the weight of the joint above: smeared wholly
constexpr double kOffBone = 0.6;       // of a bone, between a joint and where its weights begin
constexpr double kOffBoneMost = 1.25;  // ... at most: what is further off is the body's own way
constexpr double kLongBone = 0.6;      // of the torso's half width: else it has no rows of its own
constexpr double kSamePlace = 0.05;    // of the spine: a joint so near the one below is its helper
constexpr double kOnSpine = 0.5;       // of a place's weight, for the spine to move it

class OrderFinder {
 public:
  OrderFinder(const Character& character, const SkinPlaces& places, const Anatomy& anatomy)
      : character_(character), places_(places), anatomy_(anatomy) {}

  WeightAnswer find() const {
    WeightAnswer out;
    const double length = places_.arc.back();
    if (!(length > 0.0)) return out;
    std::vector<double> weight(places_.chain.size(), 0.0), along(places_.chain.size(), 0.0),
        beside(places_.chain.size(), 0.0), leads(places_.chain.size(), 0.0);
    for (Index p = 0; p < places_.weights.size(); ++p)
      for (const NodeWeight& w : places_.weights[p]) {
        if (places_.costume[places_.shell[p]]) continue;  // a belt hangs where it was put
        if (places_.on_spine[static_cast<Index>(w.node)] < 0) continue;
        const auto k = static_cast<Index>(places_.on_spine[static_cast<Index>(w.node)]);
        weight[k] += w.weight;
        if (places_.main[p] == w.node) leads[k] += w.weight;
        along[k] += w.weight * places_.along[p];
        beside[k] += w.weight * places_.beside[p];
      }
    std::vector<Index> lower;  // joints with an area, from the hips up
    bool asked = false;
    for (Index k = 0; k <= anatomy_.chest_index; ++k) {
      if (weight[k] < kLeastArea * places_.all || leads[k] < kLeads * weight[k]) continue;
      // Of joints that stand nearer to each other than the torso is thick, where the surface lies
      // says nothing: the next one down that stands far enough off is asked.
      const auto far_enough = std::find_if(lower.rbegin(), lower.rend(), [&](Index b) {
        const double half_width = (beside[b] + beside[k]) / (weight[b] + weight[k]);
        return places_.arc[k] - places_.arc[b] >= kApartInOrder * half_width;
      });
      const bool found = far_enough != lower.rend();
      const Index b = found ? *far_enough : k;
      lower.push_back(k);
      if (!found) continue;
      asked = true;
      const double back = along[b] / weight[b] - along[k] / weight[k];
      // What overlaps by less than joints that were swapped do is a matter of the body's form.
      if (!(back > kOverlaps * (places_.arc[k] - places_.arc[b]))) continue;
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
    return out;
  }

 private:
  /// Where along the chain the weights of joint k and of those above it begin, as an arc length:
  /// the cut that leaves least weight on its wrong side, over the places that the spine moves.
  double border_at(Index k) const {
    std::vector<std::pair<double, double>> places;  // along the chain, share of k and above
    double wrong = 0.0;                             // of a cut below all places
    for (Index p = 0; p < places_.weights.size(); ++p) {
      double above = 0.0, all = 0.0;
      for (const NodeWeight& w : places_.weights[p]) {
        const int on = places_.on_spine[static_cast<Index>(w.node)];
        if (on < 0) continue;
        all += w.weight;
        if (static_cast<Index>(on) >= k) above += w.weight;
      }
      if (all < kOnSpine) continue;
      places.emplace_back(places_.along[p], above / all);
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

  /// Whether the maker of the skeleton gave joint k of the chain, not its first, no skin of its
  /// own: it stands where the one below does, or the hips hang from it.
  bool is_helper(Index k) const {
    return places_.arc[k] - places_.arc[k - 1] < kSamePlace * places_.arc.back() ||
           is_ancestor(character_, anatomy_.spine[k], anatomy_.spine.front());
  }

  /// Whether two and more joints between hips and chest all have no weight: nobody smears them all,
  /// but many a game figure has a torso of one piece on a skeleton of more.
  bool is_of_one_piece() const {
    for (Index k = 1; k < anatomy_.chest_index; ++k)
      if (places_.total[static_cast<Index>(anatomy_.spine[k])] > 0.0) return false;
    return anatomy_.chest_index > 2;
  }

  /// Vertebrae smeared wholly into a neighbour: they have no weight left that could be out of
  /// order, but the weights above (or their own) then begin a bone away from where they should. Not
  /// asked of the joint after the hips, whose own area many a body lets begin behind the chain.
  void find_borders(WeightAnswer& out) const {
    if (is_of_one_piece()) return;
    for (Index k = 2; k <= anatomy_.chest_index && k + 1 < places_.chain.size(); ++k) {
      const double off = border_at(k) - places_.arc[k];
      const double bone =
          off < 0.0 ? places_.arc[k] - places_.arc[k - 1] : places_.arc[k + 1] - places_.arc[k];
      const Index smeared = off < 0.0 ? k - 1 : k;
      if (places_.total[static_cast<Index>(anatomy_.spine[smeared])] >
              kNothing * places_.total[static_cast<Index>(anatomy_.spine[k + 1])] ||
          is_helper(smeared))
        continue;
      if (std::abs(off) < kOffBone * bone || std::abs(off) > kOffBoneMost * bone ||
          bone < kLongBone * places_.half_width)
        continue;
      WeightFault fault;
      fault.node = fault.other = anatomy_.spine[k];
      fault.value = std::abs(off) / places_.arc.back();
      fault.distance = std::abs(off);
      out.faults.push_back(fault);
    }
  }

  const Character& character_;
  const SkinPlaces& places_;
  const Anatomy& anatomy_;
};

}  // namespace

WeightAnswer find_order_faults(const Character& character, const SkinPlaces& places,
                               const Anatomy& anatomy) {
  return OrderFinder(character, places, anatomy).find();
}

}  // namespace backbend::skin
