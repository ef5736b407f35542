#pragma once
#include "solver/even_places.h"
#include "solver/even_shape.h"
#include "solver/option_reader.h"

namespace backbend::solver {

/// The options `weights` and `twist` of `even`. Throws OptionError.
EvenWeights read_even_weights(OptionReader& read);

/// The options `bones` and `joints`. Throws OptionError.
EvenPlaces read_even_places(OptionReader& read);

}  // namespace backbend::solver
