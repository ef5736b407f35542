#include "skin/weights/fault_map.h"

#include <algorithm>

namespace backbend::skin {

void add_fault(const SkinPlaces& places, FaultMap& faults, int node, int other, double share,
               double distance, std::size_t place) {
  WeightFault& fault = faults[node];
  ++fault.places;
  fault.vertices.push_back(places.vertex[place]);
  fault.distance = std::max(fault.distance, distance);
  if (share <= fault.value) return;
  fault.node = node;
  fault.other = other;
  fault.value = share;
  fault.vertex = places.vertex[place];
}

void keep_patches(const SkinPlaces& places, FaultMap& faults, double fewest, double share) {
  const double least = std::max(fewest, share * static_cast<double>(places.own_count));
  std::erase_if(faults,
                [&](const auto& each) { return static_cast<double>(each.second.places) < least; });
}

void take_faults(FaultMap& from, WeightAnswer& to) {
  for (auto& [node, fault] : from) to.faults.push_back(fault);
  std::stable_sort(to.faults.begin(), to.faults.end(),
                   [](const WeightFault& a, const WeightFault& b) { return a.value > b.value; });
}

}  // namespace backbend::skin
