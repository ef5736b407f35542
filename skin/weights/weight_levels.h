#pragma once
#include "skin/weights/skin_places.h"
#include "skin/weights/weight_faults.h"

namespace backbend::skin {

/// WeightFaults::levels of a character with weights and a spine.
WeightAnswer find_level_faults(const SkinPlaces& places, const Anatomy& anatomy);

}  // namespace backbend::skin
