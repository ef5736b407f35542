#include "validate/evidence/extremes.h"

#include <algorithm>

#include "validate/judge/judge.h"

namespace backbend::validate {

std::vector<ExtremePose> find_extremes(const Stage& stage, const RigPlan& plan,
                                       solver::Mapping mapping, const std::vector<Sweep>& sweeps,
                                       const Envelope& envelope, Progress& progress) {
  const LimitSet limits;
  const JudgeContext context{stage, limits, envelope, stage.character().file_name};
  const BodyMetrics body(stage.character(), stage.anatomy(), stage.driver());
  std::size_t poses = 0;
  for (const Sweep& sweep : sweeps) poses += sweep.pose_count();
  progress.start("poses", poses);
  const RigRecord record = measure_rig(stage, body, plan, mapping, sweeps, envelope, progress);

  std::vector<ExtremePose> extremes;
  const auto add = [&](const Sweep& sweep, double control_deg, const std::string& why,
                       const std::string& caption) {
    const PoseDegrees pose = sweep.pose_at(control_deg);
    std::string label = sweep.name + "_" + number_text(control_deg, 1) + "_" + why;
    const std::string stem = label;
    for (int again = 2; std::any_of(extremes.begin(), extremes.end(),
                                    [&](const ExtremePose& each) { return each.label == label; });
         ++again) {
      label = stem + "_" + std::to_string(again);
    }
    extremes.push_back({pose, label, caption});
  };
  const std::vector<Finding> findings = judge_rig(record, context);
  for (const SweepRecord& swept : record.sweeps) {
    const Sweep& sweep = swept.sweep;
    if (!why_not_taken(*record.system, sweep.pose_at(sweep.to_deg)).empty()) continue;
    std::vector<double> seen;
    for (const Finding& finding : findings) {
      if (sweep_of(record, finding) != &swept) continue;
      if (finding.code == "BB001") {
        add(sweep, finding.geometry.at("before_deg"), "BB001_before",
            finding.pose + ": flip, before");
        add(sweep, finding.geometry.at("after_deg"), "BB001_after", finding.pose + ": flip, after");
      } else if (std::find(seen.begin(), seen.end(), finding.control_deg) == seen.end()) {
        seen.push_back(finding.control_deg);
        add(sweep, finding.control_deg, finding.code,
            finding.pose + ": " + std::string(find_check(finding.code)->name));
      }
    }
    if (extremes.empty() || extremes.back().label.rfind(sweep.name, 0) != 0)
      add(sweep, sweep.to_deg, "end", sweep.name + " " + number_text(sweep.to_deg, 1));
  }
  return extremes;
}

}  // namespace backbend::validate
