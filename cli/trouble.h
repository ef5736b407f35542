#pragma once
#include <string>

#include "validate/verdicts/exit_code.h"

namespace backbend::cli {

/// What ends a command: the line that its user sees, and its exit code.
struct Trouble {
  std::string line;
  validate::ExitCode code;
};

/// What the exception that is being handled comes to.
Trouble trouble_of_exception();

}  // namespace backbend::cli
