#pragma once
#include <string>
#include <vector>

#include "validate/judge/judge.h"

namespace backbend::validate {

/// How far one of our systems is clean on this character, with its default options, per body
/// channel: to stand beside the headroom of a rig. Measured over those of the sweeps that move one
/// channel alone, judged by `context`. Throws solver::RigError where the system cannot be built on
/// the chain; Interrupted.
std::vector<Headroom> headroom_under(const std::string& system, const BodyMetrics& body,
                                     solver::Mapping mapping, const std::vector<Sweep>& sweeps,
                                     bool judges_weights, const JudgeContext& context);

/// The systems whose headroom stands beside a rig's: `even`, and beside a rig of the studio's the
/// emulations of what other programs offer. None beside a reference or `even` itself.
std::vector<std::string> systems_beside(const RigPlan& plan);

}  // namespace backbend::validate
