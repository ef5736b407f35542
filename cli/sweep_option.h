#pragma once
#include <string>

#include "validate/sweeps/sweep.h"

namespace backbend::cli {

/// `--sweep`: validate::sweep_named(). Throws CLI::ValidationError.
validate::Sweep sweep_option(const std::string& name);

}  // namespace backbend::cli
