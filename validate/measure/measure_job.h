#pragma once
#include <string>
#include <vector>

#include "validate/files/ledger.h"
#include "validate/measure/known_jumps.h"
#include "validate/measure/measure.h"

namespace backbend::validate {

/// Units of measuring are this many poses of one sweep.
inline constexpr std::size_t kPosesOfUnit = 16;

/// The name of a unit of work on one sweep of a rig. `character` names content, so that parts of
/// another version of the same file are never taken for it.
std::string unit_name(const std::string& kind, const std::string& character, const RigRecord& rig,
                      const std::string& sweep, std::size_t number);

/// Fills planned records with every pose's and every sweep's results, from the ledger where it has
/// them. In a shard its own share is measured first, then what the others have not finished.
/// Returns false where results are missing (Mode::merge), all of them noted. `known`, where given,
/// has jumps that were found before.
bool measure_records(const Stage& stage, const BodyMetrics& body, const std::string& character,
                     std::vector<RigRecord>& records, Ledger& ledger, Progress& progress,
                     KnownJumps* known = nullptr);

}  // namespace backbend::validate
