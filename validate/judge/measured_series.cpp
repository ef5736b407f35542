#include "validate/judge/measured_series.h"

#include "validate/judge/judge_external.h"
#include "validate/sweeps/external_spec.h"

namespace backbend::validate {
namespace {

void require_taken(const RigRecord& rig, const PoseDegrees& pose) {
  if (const std::string why = why_not_taken(*rig.system, pose); !why.empty())
    throw solver::RigError("rig '" + rig.plan.name + "' cannot take the pose: " + why);
}

SweepSeries only_series(const RigRecord& rig) {
  LimitSet limits;
  if (is_external(rig.plan.spec)) limits = external_limits(std::move(limits));
  return series_of(rig, limits).front();
}

}  // namespace

SweepSeries measure_one_pose(const Stage& stage, const BodyMetrics& body, const RigPlan& plan,
                             solver::Mapping mapping, const PoseDegrees& pose) {
  Sweep sweep;
  sweep.name = "pose";
  sweep.channel = "path";
  sweep.start = pose;
  RigRecord rig = plan_rig(stage, body, plan, mapping, {sweep}, *find_envelope("sweep"));
  require_taken(rig, pose);
  Progress silent(Progress::Style::none);
  measure_poses(stage, body, rig, rig_at_rest(*rig.system), rig.sweeps.front().poses, silent);
  PoseRecord& record = rig.sweeps.front().poses.front();
  if (record.at(MetricId::non_finite).value == 0.0) measure_pose_behaviour(stage, rig, record);
  return only_series(rig);
}

SweepSeries measure_sweep(const Stage& stage, const BodyMetrics& body, const RigPlan& plan,
                          solver::Mapping mapping, const Sweep& sweep) {
  Progress silent(Progress::Style::none);
  {
    const RigRecord planned =
        plan_rig(stage, body, plan, mapping, {sweep}, *find_envelope("sweep"));
    require_taken(planned, sweep.pose_at(sweep.to_deg));
  }
  return only_series(
      measure_rig(stage, body, plan, mapping, {sweep}, *find_envelope("sweep"), silent));
}

}  // namespace backbend::validate
