#pragma once
#include <map>

#include "skin/weights/skin_places.h"
#include "skin/weights/weight_faults.h"

namespace backbend::skin {

/// Faults of one kind while they are collected, by joint.
using FaultMap = std::map<int, WeightFault>;

/// Counts a place to the fault of `node`, which is as bad as its worst place.
void add_fault(const SkinPlaces& places, FaultMap& faults, int node, int other, double share,
               double distance, std::size_t place);

/// Adds the faults to an answer, the worst of all first.
void take_faults(FaultMap& from, WeightAnswer& to);

}  // namespace backbend::skin
