#pragma once
#include <string_view>
#include <vector>

#include "validate/model/report.h"
#include "validate/sweeps/suite.h"
#include "validate/tasks/progress.h"

namespace backbend::validate {

/// Jumps on compound poses, and the short sweeps that show the two that matter most.
struct FoundJumps {
  CompoundSearch summary;
  std::vector<Sweep> around;  // 16 degrees to either side of: the jump nearest to rest, the largest
};

/// What the names of those sweeps begin with.
inline constexpr std::string_view kJumpSweep = "jump near";

/// Of a live rig, jumps below are not looked for between the sweeps: a step of the bend turns its
/// chest by 1.25 degrees between the samples that are always taken, and a smaller limit would have
/// each of them halved.
inline constexpr double kSmallestAsked_deg = 2.0;

/// What is searched: each channel as far as the envelope needs, and as far as the sweeps take it.
Envelope search_box(const Envelope& envelope, const std::vector<Sweep>& sweeps);

/// Looks for jumps of a rig at compound poses: along the whole bend, every 5 degrees and between
/// them where it moves unevenly, at each pair of a lattice of side and twist no wider than 15
/// degrees, of a live rig wider where that would be more than 4000 poses. Only the chain is solved.
/// A jump that lives on less than such a cell can be missed. `progress`, where given, shows its
/// paths.
FoundJumps search_compound(const solver::SpineSystem& system, solver::Mapping mapping,
                           const Envelope& box, Progress* progress = nullptr);

}  // namespace backbend::validate
