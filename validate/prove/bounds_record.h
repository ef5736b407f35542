#pragma once
#include <filesystem>
#include <string>

#include "validate/prove/metric_proof.h"

namespace backbend::validate {

/// What `--bound` asks of which rig and body, as one JSON text: two searches with the same text
/// look at the same boxes. `rig`: as the user named it.
std::string bounds_question(const MetricQuestion& question, const std::string& rig,
                            const solver::RestChain& chain);

/// A file of the parts that a search has decided so far, one JSON object of schema
/// `backbend.bounds_record/1`; the last key is a hash of the rest. Nothing in it is proof to
/// anybody but who made it. Appears whole or not at all. Throws WriteError.
void write_bounds_record(const std::filesystem::path& file, const std::string& question_text,
                         const MetricParts& parts);

/// Throws ReadError, and ProofError naming the file, for one that is cut, changed, of another
/// schema, program or question.
MetricParts read_bounds_record(const std::filesystem::path& file, const MetricQuestion& question,
                               const std::string& question_text);

}  // namespace backbend::validate
