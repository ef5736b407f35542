#include "cli/sweep_option.h"

#include <CLI/CLI.hpp>

#include "validate/sweeps/sweep_named.h"

namespace backbend::cli {

validate::Sweep sweep_option(const std::string& name) {
  try {
    return validate::sweep_named(name);
  } catch (const solver::RigError& error) {
    throw CLI::ValidationError(std::string("--sweep: ") + error.what());
  }
}

}  // namespace backbend::cli
