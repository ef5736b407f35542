#pragma once
#include <initializer_list>

namespace backbend::validate {

/// What the process tells its caller: the table of docs/exit_codes.md.
enum ExitCode : int {
  kExitOk = 0,
  kExitFindings = 1,
  kExitUsage = 2,
  kExitBadInput = 3,
  kExitIncomplete = 4,
  kExitNotMeasured = 5,
  kExitNoBaseline = 6,
  kExitInternal = 70,
  kExitCannotWrite = 73,
  kExitTemporary = 75,
  kExitInterrupted = 130,
  kExitTerminated = 143,
};

/// The code to report where several hold: signals, 70, 73, 75, 2, 3, 4, 1, 5, 6, then 0.
ExitCode first_exit_code(std::initializer_list<ExitCode> held);

}  // namespace backbend::validate
