#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "validate/prove/certificate.h"
#include "validate/text/terminal_style.h"

namespace backbend::validate {

/// What a proof came to, for a person: shares, the bound, the worst poses, and a map of extension
/// by side for bands of twist.
std::string proof_text(const Certificate& proof, const solver::SpineSystem& system,
                       const TerminalStyle& style);

/// `{"schema": "backbend.proof/1", ...}`, keys in a fixed order, ended by a line feed.
std::string proof_json(const Certificate& proof, const solver::SpineSystem& system);

/// A pose of a box by its channels' names; extension below 0 is flexion.
nlohmann::ordered_json pose_json(const ProofBox& box, const std::array<double, kProofAxes>& pose);

/// An upper bound to nine decimals, rounded upward.
std::string bound_text(double bound);

/// The poses of a proof, worst first: jumps by size, then gains.
std::vector<Refutation> worst_first(const ProofTree& tree);

}  // namespace backbend::validate
