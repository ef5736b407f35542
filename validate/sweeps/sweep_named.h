#pragma once
#include <string>
#include <vector>

#include "validate/sweeps/sweep.h"

namespace backbend::validate {

/// The sweep that `backbend list sweeps` shows under that name: `extension`, `stress twist`,
/// `stress grid` (all its lines in one path). Throws solver::RigError with the nearest name.
Sweep sweep_named(const std::string& name);

/// All of them: what `check` runs by itself on a human, with the corners of the envelope.
std::vector<Sweep> bundled_sweeps();

}  // namespace backbend::validate
