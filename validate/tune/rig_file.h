#pragma once
#include <string>
#include <vector>

#include "solver/rig/spine_system.h"

namespace backbend::validate {

/// A rig file, as `--rig FILE.toml` takes it: comment lines, `[rig]`, the system and the options
/// that were given a value.
std::string rig_toml(const solver::SystemSpec& spec, const std::vector<std::string>& comment);

}  // namespace backbend::validate
