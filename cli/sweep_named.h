#pragma once
#include <string>

#include "validate/sweeps/sweep.h"

namespace backbend::cli {

/// The sweep that `backbend list sweeps` shows under that name: `extension`, `stress twist`,
/// `stress grid` (all its lines in one path). Throws CLI::ValidationError with the nearest name.
validate::Sweep sweep_named(const std::string& name);

}  // namespace backbend::cli
