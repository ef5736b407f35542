#include "validate/evidence/worst_metric.h"

#include <algorithm>
#include <cmath>

#include "validate/judge/judge.h"
#include "validate/model/report.h"
#include "validate/verdicts/limits.h"

namespace backbend::validate {
namespace {

/// A value as a factor of its limit: comparable between checks.
double factor_of_limit(const Check& check, double value, double limit) {
  constexpr double kFloor = 1e-9;
  return check.sense == Sense::at_most ? value / std::max(limit, kFloor)
                                       : limit / std::max(value, kFloor);
}

}  // namespace

std::string worst_metric(const Stage& stage, const solver::SpineSystem& system,
                         const PoseDegrees& pose, solver::Mapping mapping,
                         const PosedCharacter& posed) {
  const BodyMetrics body(stage.character(), stage.anatomy(), stage.driver());
  PoseRecord record;
  record.body = pose;
  record.control = controls_at(system, pose, mapping);
  measure_pose(body, rig_at_rest(system), posed, record);
  const MetricScope scope{system.rest(), body.scope(), stage.driver().arms_follow_chest()};
  return worst_of(record, LimitSet(),
                  [&](const Metric& metric) { return is_applicable(metric, scope, record); });
}

std::string worst_of(const PoseRecord& record, const LimitSet& limits,
                     const std::function<bool(const Metric&)>& applies) {
  const Check* worst = nullptr;
  double worst_factor = -1.0, worst_value = 0.0;
  for (const Metric& metric : metric_table()) {
    const double value = record.at(metric.id).value;
    if (!std::isfinite(value) || !applies(metric)) continue;
    const Check& check = metric.check();
    const double factor = factor_of_limit(check, value, limits.of(check.code).value);
    if (factor > worst_factor) worst = &check, worst_factor = factor, worst_value = value;
  }
  if (worst == nullptr) return {};
  return std::string(worst->name) + " " + number_text(worst_value, 1) + " " +
         std::string(worst->unit) + " (limit " + number_text(limits.of(worst->code).value, 1) + ")";
}

}  // namespace backbend::validate
