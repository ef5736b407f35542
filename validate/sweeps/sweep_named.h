#pragma once
#include <string>
#include <vector>

#include "validate/sweeps/envelope.h"
#include "validate/sweeps/sweep.h"

namespace backbend::validate {

/// The sweep that `backbend list sweeps` shows under that name: `extension`, `stress twist`,
/// `stress grid` (all its lines in one path). Throws solver::RigError with the nearest name.
Sweep sweep_named(const std::string& name);

/// What `check` runs by itself: the standard sweeps of the envelope, then those to its corners.
std::vector<Sweep> bundled_sweeps(const Envelope& envelope = *find_envelope("human"));

}  // namespace backbend::validate
