#pragma once
#include "skin/weights/skin_places.h"
#include "skin/weights/weight_faults.h"

namespace backbend::skin {

/// WeightFaults::seams.
WeightAnswer find_seam_faults(const Character& character, const Anatomy& anatomy,
                              const SkinPlaces& places);

}  // namespace backbend::skin
