#pragma once
#include <string_view>

#include "solver/rig/box_solver.h"

namespace backbend::validate {

/// The most that a check of the chain can be over a box, in the check's unit: BB020 (arms turned
/// against the chest control, degrees), BB021 (arms moved against it), BB041 (end gap) and BB047
/// (length change), the last three in % of the spine. Infinite where no bound is known.
double most_of_chain(std::string_view check, const solver::SpineSystem& system,
                     const solver::BoxPlaces& places);

}  // namespace backbend::validate
