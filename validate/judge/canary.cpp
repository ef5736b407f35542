#include "validate/judge/canary.h"

#include <algorithm>
#include <cmath>

namespace backbend::validate {
namespace {

std::vector<Finding> findings_of(const RigPlan& plan, const CanaryDuty& duty,
                                 const std::vector<Sweep>& sweeps, const JudgeContext& context) {
  const RigRecord record =
      measure_chain_only(context.stage, plan, duty.mapping, sweeps, context.envelope);
  std::vector<Finding> findings = judge_rig(record, context);
  std::erase_if(findings, [&](const Finding& finding) { return finding.code != duty.code; });
  return findings;
}

/// The angle to compare with the declared one: of a flip where it is, of anything else where it
/// begins.
double angle_of(const Finding& finding) {
  const auto first = finding.geometry.find("first_deg");
  return first == finding.geometry.end() ? finding.control_deg : first->second;
}

bool names_joint(const Finding& finding, const std::string& joint) {
  return joint.empty() || finding.joint == joint || finding.detail.find(joint) != std::string::npos;
}

}  // namespace

CanaryResult run_canary(const RigPlan& canary, const std::vector<Sweep>& sweeps,
                        const JudgeContext& context) {
  const CanaryDuty& duty = *canary.duty;
  CanaryResult result;
  result.rig = canary.name;
  result.code = duty.code;
  result.joint = duty.joint;
  result.expected_deg = duty.control_deg;
  result.tolerance_deg = duty.tolerance_deg;
  result.found_deg = std::nan("");

  std::vector<Sweep> own;
  std::copy_if(sweeps.begin(), sweeps.end(), std::back_inserter(own),
               [&](const Sweep& sweep) { return sweep.name == duty.sweep; });
  for (const Finding& finding : findings_of(canary, duty, own, context)) {
    if (!names_joint(finding, duty.joint)) continue;
    const double angle = angle_of(finding);
    const bool nearer =
        std::isnan(result.found_deg) ||
        std::abs(angle - duty.control_deg) < std::abs(result.found_deg - duty.control_deg);
    if (nearer) result.found_deg = angle;
  }
  result.found = std::abs(result.found_deg - duty.control_deg) <= duty.tolerance_deg;

  RigPlan twin = canary;
  twin.spec = duty.twin;
  const std::vector<Finding> twin_findings = findings_of(twin, duty, own, context);
  result.twin_clean = twin_findings.empty();

  const std::string place = duty.joint.empty() ? "" : " at " + duty.joint;
  if (std::isnan(result.found_deg)) {
    result.detail = duty.code + place + " was not found at all";
  } else {
    result.detail = duty.code + place + " found at " + duty.sweep + " " +
                    number_text(result.found_deg, 2) + ", expected " +
                    number_text(duty.control_deg, 2) + " +- " + number_text(duty.tolerance_deg, 2);
  }
  if (!result.twin_clean)
    result.detail += "; its repaired twin shows it too: " + twin_findings.front().detail;
  return result;
}

}  // namespace backbend::validate
