#include "skin/weights/weight_levels.h"

#include <algorithm>
#include <cmath>

namespace backbend::skin {
namespace {

using Index = std::size_t;

struct OffBone {
  Index vertebra = 0;
  double by = 0.0;  // along the chain, towards the hips negative
};

}  // namespace

WeightAnswer find_level_faults(const SkinPlaces& places, const Anatomy& anatomy) {
  WeightAnswer out;
  std::vector<double> weight(places.chain.size(), 0.0), along(places.chain.size(), 0.0);
  std::vector<bool> leads(places.chain.size(), false);
  for (Index p = 0; p < places.weights.size(); ++p)
    for (const NodeWeight& w : places.weights[p]) {
      const int on = places.on_spine[static_cast<Index>(w.node)];
      if (on < 0 || places.costume[places.shell[p]]) continue;
      weight[static_cast<Index>(on)] += w.weight;
      along[static_cast<Index>(on)] += w.weight * places.along[p];
      if (places.main[p] == w.node) leads[static_cast<Index>(on)] = true;
    }
  // Hips and chest hold areas of their own, beyond their bones.
  std::vector<OffBone> off;
  for (Index k = 1; k < anatomy.chest_index; ++k) {
    if (weight[k] < kLeastArea * places.all) continue;
    // One that leads nowhere only adds to the areas around it, as on a coarse body between two
    // rings: it has no place of its own to be off.
    if (!leads[k]) {
      off.push_back({k, 0.0});
      continue;
    }
    // A bone leads to the joint that hangs from it: of a spine that hangs from its chest,
    // downwards.
    const bool hangs_below =
        places.parent[static_cast<Index>(anatomy.spine[k - 1])] == anatomy.spine[k];
    const Index low = hangs_below ? k - 1 : k;
    const double middle = along[k] / weight[k];
    off.push_back({k, middle - std::clamp(middle, places.arc[low], places.arc[low + 1])});
  }
  if (off.empty()) {
    out.not_applicable = "no vertebra between hips and chest has weight";
    return out;
  }
  // The median: one vertebra with an odd area says nothing of the others, and BB066 asks for it.
  std::ranges::sort(off, {}, &OffBone::by);
  const OffBone &low = off[(off.size() - 1) / 2], &high = off[off.size() / 2];
  const OffBone& middle = std::abs(low.by) < std::abs(high.by) ? low : high;
  if (middle.by == 0.0 || low.by * high.by < 0.0) return out;
  WeightFault fault;
  fault.node = anatomy.spine[middle.vertebra];
  fault.other = anatomy.spine[middle.by < 0.0 ? middle.vertebra - 1 : middle.vertebra + 1];
  fault.distance = std::abs(middle.by);
  fault.value = fault.distance / places.arc[anatomy.chest_index];
  out.faults.push_back(fault);
  return out;
}

}  // namespace backbend::skin
