#pragma once
#include "validate/clips/clip_measure.h"
#include "validate/model/report.h"
#include "validate/verdicts/limits.h"

namespace backbend::validate {

/// What judging a clip needs to know beside its measurements.
struct ClipContext {
  const skin::Character& character;
  const skin::Anatomy& anatomy;
  const skin::Clip& clip;
  const ClipBody& body;
  const ClipSystem& system;
  const BodyMetrics* metrics;  // null for a skeleton without a body
  const LimitSet& limits;
  std::string command;  // that shows a finding again
};

/// The owner of the motion: RIG where the clip records controls or holds points only; else MOTION
/// (captured or keyed).
Owner owner_of_motion(const skin::Clip& clip);

/// The limits of a rig whose motion is all that is known of it.
LimitSet clip_limits();

/// Every finding of a clip, worst first: jumps one by one, for the other checks the worst frame of
/// each sweep. What only a rig's controls could tell is not applicable.
std::vector<Finding> judge_clip(const ClipRecord& record, const ClipContext& context);

/// Says of each finding on the mesh whose it is, and whether it decides: only what an even bend
/// with the same ends and weights would not show as well.
void book_clip_owners(const ClipContext& context, const ClipRecord& record,
                      std::vector<Finding>& findings);

std::vector<Coverage> clip_coverage(const ClipRecord& record);
std::vector<SweepSeries> clip_series(const ClipRecord& record, const LimitSet& limits);

/// Turns one joint of the clip's longest sweep by half a turn from its middle on: found there and
/// nowhere before, or the test has measured nothing. The twin is the clip as it is.
CanaryResult clip_canary(const ClipRecord& record, const ClipContext& context);

}  // namespace backbend::validate
