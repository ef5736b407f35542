#include "validate/run/owner.h"

#include <algorithm>
#include <limits>

#include "validate/verdicts/booking.h"

namespace backbend::validate {
namespace {

std::optional<MetricId> metric_of(const std::string& code) {
  for (std::size_t m = 0; m < kMetricCount; ++m) {
    if (pose_metrics()[m].code == code) return static_cast<MetricId>(m);
  }
  return std::nullopt;
}

PoseRecord measured(const Stage& stage, const BodyMetrics& body, const solver::SpineSystem& system,
                    solver::Mapping mapping, const PoseDegrees& pose, skin::SkinningMethod method) {
  PoseRecord record;
  record.body = pose;
  record.control = controls_at(system, pose, mapping);
  measure_pose(body, rig_at_rest(system), stage.pose(system, record.control, method), record);
  return record;
}

PoseDegrees pose_of(const RigRecord& rig, const Finding& finding) {
  const auto sweep =
      std::find_if(rig.sweeps.begin(), rig.sweeps.end(),
                   [&](const SweepRecord& each) { return each.sweep.name == finding.sweep; });
  return sweep->sweep.pose_at(finding.control_deg);
}

}  // namespace

void book_owners(const Stage& stage, const BodyMetrics& body, const RigRecord& rig,
                 bool judges_weights, std::vector<Finding>& findings) {
  const std::unique_ptr<solver::SpineSystem> ideal = stage.build({"even", {}});
  for (Finding& finding : findings) {
    const Check& check = *find_check(finding.code);
    const auto metric = metric_of(finding.code);
    if (check.subject != Subject::mesh || !metric) continue;
    const PoseDegrees pose = pose_of(rig, finding);
    const PoseRecord clean =
        measured(stage, body, *ideal, rig.mapping, pose, skin::SkinningMethod::linear);
    const PoseRecord dual = measured(stage, body, *rig.system, rig.mapping, pose,
                                     skin::SkinningMethod::dual_quaternion);
    MeshContext facts;
    facts.value = finding.value;
    facts.ideal = clean.at(*metric).value;
    facts.proxy = std::numeric_limits<double>::quiet_NaN();
    facts.infeasible = clean.at(MetricId::feasibility).value;
    facts.judging_weights = judges_weights;
    const Booking booking = book_mesh_finding(check, finding.limit, facts);
    finding.owner = booking.owner;
    if (!booking.decides) finding.verdict = Verdict::stress;
    finding.geometry["ideal"] = facts.ideal;
    finding.geometry["dual_quaternion"] = dual.at(*metric).value;
    finding.detail += "; the ideal bend gives " + number_text(facts.ideal, 3) +
                      ", dual quaternions would give " + number_text(dual.at(*metric).value, 3);
    if (booking.owner == Owner::pose) {
      finding.detail += "; too thick to bend this far, no fault of the rig";
    }
  }
}

}  // namespace backbend::validate
