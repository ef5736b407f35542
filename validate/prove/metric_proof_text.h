#pragma once
#include <string>

#include "solver/rig/spine_system.h"
#include "validate/prove/metric_proof.h"
#include "validate/text/terminal_style.h"

namespace backbend::validate {

/// What became of each claim, for a person: shares, what was proved, the worst pose that was
/// measured, and a map for each claim that does not hold everywhere. `rig`: as the user named it.
std::string metric_proof_text(const MetricQuestion& question, const MetricProof& proof,
                              const std::string& rig, const TerminalStyle& style);

/// `{"schema": "backbend.bounds/1", ...}`, keys in a fixed order, ended by a line feed.
std::string metric_proof_json(const MetricQuestion& question, const MetricProof& proof,
                              const std::string& rig);

}  // namespace backbend::validate
