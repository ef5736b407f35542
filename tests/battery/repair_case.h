#pragma once
#include <filesystem>
#include <string>

#include "tests/battery/weight_faults.h"

namespace backbend::battery {

/// What a repair made of a body with a planted fault.
struct RepairScore {
  std::string refused;      // why the file was not taken; empty: it was
  std::size_t planted = 0;  // findings of the weights that the body without the fault has not
  std::size_t left = 0;     // of those, after the repair
  std::size_t added = 0;    // findings of the weights that neither has
  std::size_t vertices = 0, faulty = 0;  // all, and those that the fault changed
  std::size_t touched = 0, beyond = 0;   // changed by the repair, and of those not by the fault
  double largest_change = 0.0;
  // Mean share of a vertex's weight that is not where the body without the fault has it, over the
  // vertices that either changed, before and after.
  double off_before = 0.0, off_after = 0.0;
  std::size_t poses = 0, new_at_poses = 0;  // drawn poses, and findings there that the repair made
  std::size_t measurements = 0;
  std::vector<std::string> done;  // the changes that were kept
  double seconds = 0.0;           // of the repair alone
};

/// Repairs `faulted`, the welded() `healthy` with a fault, by way of a file in `scratch`, and holds
/// it against `healthy`. `poses`: drawn from the seed inside the envelope, at which no check may
/// fail that did not fail before.
RepairScore score_repair(const skin::Character& healthy, const skin::Character& faulted,
                         const WeightFault& fault, const std::filesystem::path& scratch,
                         std::size_t poses, std::uint64_t seed);

}  // namespace backbend::battery
