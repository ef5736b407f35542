#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "validate/measure/measure.h"

namespace backbend::validate {

// Findings name the command that may cure them. What it would give is not promised: each of those
// commands measures again.

/// Failures of the weights name `repair`. Only glTF can be repaired, and only with the spine for
/// the driven chain. `words` is the character as commands name it.
void offer_repair(const std::filesystem::path& file, const std::string& character,
                  const std::string& words, DrivenChain chain, std::vector<Finding>& findings);

/// Failures that a proposed system of ours makes name `tune`, where it has options to search.
void offer_tune(const RigRecord& rig, const solver::RestChain& rest, DrivenChain chain,
                const std::string& words, std::vector<Finding>& findings);

}  // namespace backbend::validate
