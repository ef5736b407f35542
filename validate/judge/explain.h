#pragma once
#include <string>

#include "solver/rig/solve_file.h"

namespace backbend::validate {

/// One solved pose explained to a person: inputs, options, order of evaluation, measures, what
/// drifted and why, and the fallbacks that were needed. Angles in degrees.
std::string explain_solve(const solver::SolveFile& file);

}  // namespace backbend::validate
