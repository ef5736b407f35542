#pragma once
#include <string>
#include <vector>

#include "validate/report/report.h"
#include "validate/run/measure.h"
#include "validate/verdicts/limits.h"

namespace backbend::validate {

/// What judging needs to know beside the measurements.
struct JudgeContext {
  const Stage& stage;
  const LimitSet& limits;
  const Envelope& envelope;
  std::string character;  // the file as the user named it, for reproduce lines
};

/// Every finding of one rig: flips one by one, for the other checks the worst pose of each sweep
/// where a limit is exceeded, inside the envelope if anywhere there. Worst first.
std::vector<Finding> judge_rig(const RigRecord& rig, const JudgeContext& context);

/// Per body channel: the largest angle up to which no deciding check fails, over the sweeps that
/// move that channel alone.
std::vector<Headroom> headroom_of(const RigRecord& rig, const JudgeContext& context);

/// Planned, measured and not measured, for every check that is measured at poses.
std::vector<Coverage> coverage_of(const RigRecord& rig);

/// The plotted values of a rig.
std::vector<SweepSeries> series_of(const RigRecord& rig, const LimitSet& limits);

/// Whether a value of this metric says anything about this pose: lost twist does not in a bend,
/// a flip margin not in a rig without singular poses.
bool is_applicable(const RigRecord& rig, MetricId metric, const PoseRecord& pose);

/// The joint's name in the pose, or an empty text for -1.
std::string joint_name(const RigRecord& rig, int joint);

}  // namespace backbend::validate
