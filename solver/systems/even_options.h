#pragma once
#include "solver/rig/option_reader.h"
#include "solver/systems/even_places.h"
#include "solver/systems/even_shape.h"

namespace backbend::solver {

/// The options `weights` and `twist` of `even`. Throws OptionError.
EvenWeights read_even_weights(OptionReader& read);

/// The options `bones` and `joints`. Throws OptionError.
EvenPlaces read_even_places(OptionReader& read);

}  // namespace backbend::solver
