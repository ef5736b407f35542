#pragma once
#include <string>
#include <vector>

#include "validate/sweeps/sweep.h"

namespace backbend::cli {

/// The standard sweep of that name. Throws CLI::ValidationError with the nearest name.
validate::Sweep sweep_named(const std::string& name);

/// All of them: what `check` runs by itself on a human, with the corners of the envelope.
std::vector<validate::Sweep> bundled_sweeps();

}  // namespace backbend::cli
