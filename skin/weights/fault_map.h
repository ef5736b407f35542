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

/// Drops what has fewer places than `fewest` and than `share` of all: single slips are for the
/// check of stray vertices.
void keep_patches(const SkinPlaces& places, FaultMap& faults, double fewest = 6.0,
                  double share = 0.005);

/// Adds the faults to an answer, the worst of all first.
void take_faults(FaultMap& from, WeightAnswer& to);

}  // namespace backbend::skin
