#pragma once
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "validate/measure/measure.h"
#include "validate/model/report.h"

namespace backbend::validate {

// Findings name the commands that may cure them, and what was measured that speaks for each. Those
// commands measure again.

/// Failures of the weights of one character name `repair`, with what clean weights give in the
/// pose. Only glTF that is not compressed can be repaired, and only with the spine for the driven
/// chain. `words` is the character as commands name it.
void offer_repair(const std::filesystem::path& file, const std::string& words, DrivenChain chain,
                  std::span<Finding> findings);

/// Failures that a proposed system of ours makes name `tune`, where it has options to search.
void offer_tune(const RigRecord& rig, const solver::RestChain& rest, DrivenChain chain,
                const std::string& words, std::vector<Finding>& findings);

/// Failures of a proposed rig that `even` does not have in the same pose name `export even`, with
/// the headroom of `even` on this character. For the spine alone.
void offer_even(DrivenChain chain, const std::string& words, const std::vector<Headroom>& of_even,
                std::vector<Finding>& findings);

}  // namespace backbend::validate
