#pragma once
#include <string>

#include "validate/sweeps/sweep.h"

namespace backbend::cli {

/// The standard sweep of that name. Throws CLI::ValidationError with the nearest name.
validate::Sweep sweep_named(const std::string& name);

}  // namespace backbend::cli
