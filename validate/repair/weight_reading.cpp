#include "validate/repair/weight_reading.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "validate/judge/judge.h"
#include "validate/judge/judge_input.h"
#include "validate/judge/owner.h"
#include "validate/judge/place.h"
#include "validate/measure/measure.h"
#include "validate/stage/stage.h"
#include "validate/sweeps/halton.h"
#include "validate/sweeps/suite.h"
#include "validate/sweeps/sweep_named.h"
#include "validate/verdicts/booking.h"
#include "validate/verdicts/checks.h"

namespace backbend::validate {
namespace {

void worsen(std::map<std::string, double>& excess_of, const Check& check, double value,
            double limit) {
  if (!std::isfinite(value)) return;
  double& worst = excess_of[std::string(check.code)];
  worst = std::max(worst, limit > 0.0 ? excess(check, value, limit) : value);
}

void add_mesh(const RigRecord& rig, const ReadingContext& context, WeightReading& out) {
  for (const Metric& metric : metric_table()) {
    const Check& check = metric.check();
    if (check.subject != Subject::mesh || !check.decides) continue;
    const double limit = context.limits.of(check.code).value;
    for (const SweepRecord& sweep : rig.sweeps)
      for (const PoseRecord& pose : sweep.poses) {
        if (!pose.inside || !pose.taken || pose.at(MetricId::feasibility).value >= 1.0 ||
            !is_applicable(rig, metric, pose))
          continue;
        worsen(out.excess, check, pose.at(metric.id).value,
               limit_at(check.code, limit, compound_load(context.envelope, pose.body)));
      }
  }
}

void add_file(const skin::Character& character, const ReadingContext& context, WeightReading& out) {
  const auto add = [&](std::string_view code, double value) {
    worsen(out.excess, *find_check(code), value, context.limits.of(code).value);
  };
  add("BB060", 100.0 * std::abs(1.0 - character.worst_weight_sum));
  add("BB061", static_cast<double>(character.unweighted.size()));
  add("BB062", static_cast<double>(out.input.hygiene.stray));
  add("BB063", 100.0 * out.input.faults.wrong_side.worst());
  add("BB064", 100.0 * out.input.faults.far.worst());
  add("BB065", 100.0 * out.input.faults.asymmetry.worst());
  add("BB066", 100.0 * out.input.faults.order.worst());
  add("BB067", 100.0 * out.input.faults.seams.worst());
  add("BB069", 100.0 * out.input.faults.borders.worst());
  add("BB075", 100.0 * out.input.faults.levels.worst());
}

}  // namespace

std::vector<PoseDegrees> scattered_poses(const Envelope& envelope, std::size_t count) {
  std::vector<PoseDegrees> out;
  for (std::size_t i = 1; i <= count; ++i) {
    const auto between = [i](double low, double high, unsigned base) {
      return low + (high - low) * halton(i, base);
    };
    const double bend = between(-envelope.flexion, envelope.extension, 2);
    out.push_back({std::max(bend, 0.0), std::max(-bend, 0.0),
                   between(-envelope.side, envelope.side, 3),
                   between(-envelope.twist, envelope.twist, 5)});
  }
  return out;
}

std::vector<std::set<std::string>> failing_at(const skin::Character& character,
                                              const ReadingContext& context,
                                              std::span<const PoseDegrees> poses) {
  const Stage stage(character, context.anatomy);
  const BodyMetrics body(stage.character(), stage.anatomy(), stage.driver());
  const RigRecord rig =
      plan_rig(stage, body, read_rig("even"), solver::Mapping::chest, {}, context.envelope);
  const RigAtRest at_rest = rig_at_rest(*rig.system);
  std::vector<std::set<std::string>> out(poses.size());
  oneapi::tbb::parallel_for(std::size_t{0}, poses.size(), [&](std::size_t i) {
    PoseRecord pose;
    pose.body = poses[i];
    pose.control = controls_at(*rig.system, pose.body, rig.mapping);
    measure_pose(body, at_rest, stage.pose(*rig.system, pose.control), pose);
    if (pose.at(MetricId::feasibility).value >= 1.0) return;
    for (const Metric& metric : metric_table()) {
      const Check& check = metric.check();
      if (check.subject != Subject::mesh || !check.decides || !is_applicable(rig, metric, pose))
        continue;
      const double limit = limit_at(check.code, context.limits.of(check.code).value,
                                    compound_load(context.envelope, pose.body));
      if (judge(check, pose.at(metric.id).value, weights_limit(check, limit)) == Verdict::fail)
        out[i].insert(std::string(check.code));
    }
  });
  return out;
}

WeightReading read_weights(const skin::Character& character, const ReadingContext& context,
                           Progress& progress) {
  const Stage stage(character, context.anatomy);
  const BodyMetrics body(stage.character(), stage.anatomy(), stage.driver());
  RigRecord rig = plan_rig(stage, body, read_rig("even"), solver::Mapping::chest,
                           bundled_sweeps(context.envelope), context.envelope);
  const RigAtRest at_rest = rig_at_rest(*rig.system);
  WeightReading out;
  for (const SweepRecord& sweep : rig.sweeps) out.poses += sweep.poses.size();
  progress.start("poses", out.poses);
  for (SweepRecord& sweep : rig.sweeps) {
    poll_interrupt();
    measure_poses(stage, body, rig, at_rest, sweep.poses, progress);
  }
  const JudgeContext judging{stage, context.limits, context.envelope, context.words};
  progress.finish();
  out.findings = judge_rig(rig, judging);
  book_owners(stage, body, rig, true, out.findings);
  out.input = read_input(stage);
  InputJudgement file = judge_input(rig, judging, out.input, body, true);
  for (Finding& finding : file.findings) out.findings.push_back(std::move(finding));
  const PlaceNames places(stage.character(), stage.anatomy(), &body);
  for (Finding& finding : out.findings) places.name({}, finding);
  add_mesh(rig, context, out);
  add_file(stage.character(), context, out);
  for (const Slice& slice : body.slices().slice) out.slice_at.push_back(slice.s);
  out.coordinate = body.coordinate();
  return out;
}

}  // namespace backbend::validate
