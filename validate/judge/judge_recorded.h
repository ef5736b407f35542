#pragma once
#include <string>
#include <vector>

#include "validate/judge/judge.h"

namespace backbend::validate {

/// The limits of a rig whose motion is all that is known of it.
LimitSet clip_limits();

/// What a frame of a recorded sweep is called: the value of the leading channel, the file's own
/// frame and second, or its number where poses have no time.
std::string frame_text(const SweepRecord& sweep, std::size_t pose);

/// Adds what a recorded sweep shows beside its metrics: jumps one by one, those of several joints
/// between the same two frames as one (BB001); a joint without a rotation (BB050); a channel whose
/// control does not turn the chest as its name says (BB049); and share_finding().
void judge_recorded(const RigRecord& rig, const JudgeContext& context, const SweepRecord& sweep,
                    std::vector<Finding>& findings);

/// Completes a finding of a metric at a frame, whose value and place are set: its joint, its story,
/// and whether it decides.
void describe_recorded(const RigRecord& rig, const JudgeContext& context, const SweepRecord& sweep,
                       const Metric& metric, Finding& finding);

}  // namespace backbend::validate
