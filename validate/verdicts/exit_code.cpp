#include "validate/verdicts/exit_code.h"

#include <algorithm>
#include <array>

namespace backbend::validate {

ExitCode first_exit_code(std::initializer_list<ExitCode> held) {
  constexpr std::array kOrder = {kExitTerminated,  kExitInterrupted, kExitInternal,
                                 kExitCannotWrite, kExitTemporary,   kExitUsage,
                                 kExitBadInput,    kExitIncomplete,  kExitFindings,
                                 kExitNotMeasured, kExitNoBaseline};
  for (const ExitCode code : kOrder) {
    if (std::find(held.begin(), held.end(), code) != held.end()) return code;
  }
  return kExitOk;
}

}  // namespace backbend::validate
