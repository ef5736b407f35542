#pragma once
#include "validate/judge/judge.h"

namespace backbend::validate {

/// Every metric of one pose of a rig on a character: a series of one value each, NaN where it does
/// not apply to one pose alone (jumps) or was not measured. Throws solver::RigError where the rig
/// cannot take the pose.
SweepSeries measure_one_pose(const Stage& stage, const BodyMetrics& body, const RigPlan& plan,
                             solver::Mapping mapping, const PoseDegrees& pose);

/// Every metric of every pose of a sweep, as plots and report.json hold them, against the default
/// limits. Throws solver::RigError as above; Interrupted.
SweepSeries measure_sweep(const Stage& stage, const BodyMetrics& body, const RigPlan& plan,
                          solver::Mapping mapping, const Sweep& sweep);

}  // namespace backbend::validate
