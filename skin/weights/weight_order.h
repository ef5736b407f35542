#pragma once
#include "skin/weights/skin_places.h"
#include "skin/weights/weight_faults.h"

namespace backbend::skin {

/// WeightFaults::order of a character with weights and a spine.
WeightAnswer find_order_faults(const Character& character, const SkinPlaces& places,
                               const Anatomy& anatomy);

}  // namespace backbend::skin
