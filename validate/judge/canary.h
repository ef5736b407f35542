#pragma once
#include "validate/judge/judge.h"
#include "validate/model/report.h"

namespace backbend::validate {

/// Runs a canary: its fault must be found with the declared code, at the declared angle
/// and joint, and its repaired twin must be without any finding of that code on the same sweep.
/// Only the chain is measured.
CanaryResult run_canary(const RigPlan& canary, const std::vector<Sweep>& sweeps,
                        const JudgeContext& context);

}  // namespace backbend::validate
