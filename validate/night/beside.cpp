#include "validate/night/beside.h"

#include <algorithm>

#include "validate/judge/owner.h"
#include "validate/sweeps/external_spec.h"

namespace backbend::validate {

std::vector<Headroom> headroom_under(const std::string& system, const BodyMetrics& body,
                                     solver::Mapping mapping, const std::vector<Sweep>& sweeps,
                                     bool judges_weights, const JudgeContext& context) {
  std::vector<Sweep> single;
  for (const Sweep& sweep : sweeps)
    if (std::ranges::any_of(kBendChannels, [&](auto each) { return moves_alone(sweep, each); }))
      single.push_back(sweep);
  Progress silent(Progress::Style::none);
  const RigPlan plan{system, {system, {}}, Role::reference, {}};
  const RigRecord record =
      measure_rig(context.stage, body, plan, mapping, single, context.envelope, silent);
  std::vector<Finding> findings = judge_rig(record, context);
  book_owners(context.stage, body, record, judges_weights, findings);
  return headroom_of(record, context, findings);
}

std::vector<std::string> systems_beside(const RigPlan& plan) {
  if (plan.role != Role::proposed) return {};
  if (is_external(plan.spec)) return {"even", "matrix_blend", "spline_ik"};
  if (plan.spec.system == "even" && plan.spec.options.empty()) return {};
  return {"even"};
}

}  // namespace backbend::validate
