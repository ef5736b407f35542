#include "validate/evidence/worst_metric.h"

#include <gtest/gtest.h>

#include <cmath>

#include "validate/calibrate/calibration_body.h"
#include "validate/measure/measure.h"
#include "validate/verdicts/checks.h"

namespace backbend::validate {
namespace {

const CalibrationBody& tube() {
  static const auto body = tube_body(10);
  return *body;
}

/// By how many times a metric misses its limit.
double factor(const PoseRecord& record, MetricId metric) {
  const Check& check = metric_table()[static_cast<std::size_t>(metric)].check();
  return check.sense == Sense::at_most ? record.at(metric).value / check.limit
                                       : check.limit / record.at(metric).value;
}

// Arms on the Top control do not drift, and the chain's end lacks the hidden Euler twist,
// 2 atan(tan(30 deg) tan(22.5 deg)) = 27 deg: as lost twist five times its limit, further than any
// other check. But lost twist means something in pure twists only.
TEST(WorstMetric, NamesOnlyMetricsThatApplyToThePose) {
  const auto system = tube().stage().build(read_rig("curve:arms=top").spec);
  const PoseDegrees pose = parse_pose("flexion=60,side=45");
  PoseRecord record;
  record.body = pose;
  record.control = controls_at(*system, pose, solver::Mapping::chest);
  const PosedCharacter posed = tube().stage().pose(*system, record.control);
  measure_pose(tube().metrics(), rig_at_rest(*system), posed, record);
  EXPECT_GT(factor(record, MetricId::lost_twist), 5.0);
  for (std::size_t m = 0; m < kMetricCount; ++m) {
    const double other = factor(record, static_cast<MetricId>(m));
    if (std::isfinite(other)) {
      EXPECT_LE(other, factor(record, MetricId::lost_twist)) << metric_table()[m].name;
    }
  }

  const std::string text =
      worst_metric(tube().stage(), *system, pose, solver::Mapping::chest, posed);
  EXPECT_NE(text, "");
  EXPECT_FALSE(text.starts_with("lost twist")) << text;
}

}  // namespace
}  // namespace backbend::validate
