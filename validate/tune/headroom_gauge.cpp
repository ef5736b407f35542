#include "validate/tune/headroom_gauge.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "validate/judge/judge.h"

namespace backbend::validate {
namespace {

using Index = std::size_t;

constexpr Index kCurvePointCount = 33;  // of a spine: four for each bone of an eight-bone chain
constexpr double kEqual = 0.1;          // of a limit: apart by less counts as equal, as in booking

/// From rest through the end of a direction and as far again.
Sweep sweep_through(const Direction& direction) {
  Sweep sweep;
  sweep.name = direction.name;
  double length = 0.0;
  for (const std::string_view channel : kBendChannels) {
    const double value = std::abs(*direction.end.find(channel));
    if (value > length) {
      length = value;
      sweep.channel = channel;
    }
  }
  for (const std::string_view channel : kBendChannels)
    *sweep.per_degree.find(channel) = *direction.end.find(channel) / length;
  sweep.to_deg = HeadroomGauge::kFurthest * length;
  sweep.step_deg = length / HeadroomGauge::kSteps;
  return sweep;
}

/// Points of a chain at equal steps of its arc.
std::vector<glm::dvec3> along(const std::vector<glm::dvec3>& chain) {
  std::vector<double> arc{0.0};
  for (Index i = 1; i < chain.size(); ++i)
    arc.push_back(arc.back() + glm::distance(chain[i - 1], chain[i]));
  std::vector<glm::dvec3> out;
  Index i = 1;
  for (Index k = 0; k < kCurvePointCount; ++k) {
    const double s = arc.back() * static_cast<double>(k) / (kCurvePointCount - 1);
    while (i + 1 < chain.size() && arc[i] < s) ++i;
    const double step = arc[i] - arc[i - 1];
    out.push_back(glm::mix(chain[i - 1], chain[i], step > 0.0 ? (s - arc[i - 1]) / step : 0.0));
  }
  return out;
}

}  // namespace

std::vector<Direction> directions_of(const Envelope& envelope) {
  std::vector<Direction> out;
  const auto add = [&](const PoseDegrees& end) {
    if (end.text() != PoseDegrees().text()) out.push_back({end.text(), end});
  };
  add({envelope.extension});
  add({0, envelope.flexion});
  for (const double sign : {1.0, -1.0}) add({0, 0, sign * envelope.side});
  for (const double sign : {1.0, -1.0}) add({0, 0, 0, sign * envelope.twist});
  for (const Sweep& corner : corner_sweeps(envelope)) add(corner.pose_at(corner.to_deg));
  return out;
}

HeadroomGauge::HeadroomGauge(const Stage& stage, const BodyMetrics& body, const Envelope& envelope,
                             const LimitSet& limits, solver::Mapping mapping,
                             const solver::SystemSpec& given)
    : stage_(stage),
      body_(body),
      envelope_(envelope),
      limits_(limits),
      mapping_(mapping),
      directions_(directions_of(envelope)) {
  for (const Direction& direction : directions_) sweeps_.push_back(sweep_through(direction));
  given_ = curves_of(planned(given));
  // `even` is the ideal bend; whatever it shows with other options is its own.
  against_ideal_ = given.system != "even";
  if (!against_ideal_) return;
  RigRecord ideal = planned({"even", {}});
  const RigAtRest at_rest = rig_at_rest(*ideal.system);
  oneapi::tbb::parallel_for(Index{0}, ideal.sweeps.size(), [&](Index d) {
    for (PoseRecord& pose : ideal.sweeps[d].poses)
      measure_pose(body_, at_rest, stage_.pose(*ideal.system, pose.control), pose,
                   Crossing::left_out);
  });
  for (SweepRecord& sweep : ideal.sweeps) ideal_.push_back(std::move(sweep.poses));
}

Index HeadroomGauge::poses() const {
  Index sum = 0;
  for (const Sweep& sweep : sweeps_) sum += sweep.pose_count();
  return sum;
}

RigRecord HeadroomGauge::planned(const solver::SystemSpec& spec) const {
  return plan_rig(stage_, body_, {spec.system, spec, Role::proposed, std::nullopt}, mapping_,
                  sweeps_, envelope_);
}

std::vector<HeadroomGauge::Points> HeadroomGauge::curves_of(const RigRecord& rig) const {
  std::vector<Points> out;
  for (const SweepRecord& sweep : rig.sweeps)
    for (Index i = 1; i <= static_cast<Index>(kSteps) && i < sweep.poses.size(); ++i)
      out.push_back(along(rig.system->solve(sweep.poses[i].control).position));
  return out;
}

HeadroomGauge::Nearest HeadroomGauge::nearest_limit(const RigRecord& rig, const PoseRecord& pose,
                                                    Index direction, Index step) const {
  Nearest out;
  // Limits of a compound pose hold beyond the envelope's end, too.
  const double share = std::min(1.0, static_cast<double>(step) / kSteps);
  PoseDegrees inside;
  for (const std::string_view channel : kBendChannels)
    *inside.find(channel) = share * *directions_[direction].end.find(channel);
  const double load = compound_load(envelope_, inside);
  const bool infeasible = pose.at(MetricId::feasibility).value >= 1.0;
  for (const Metric& metric : metric_table()) {
    const Check& check = metric.check();
    const bool on_mesh = check.subject == Subject::mesh;
    if (!check.decides || metric.id == MetricId::gain || (on_mesh && infeasible)) continue;
    const double value = pose.at(metric.id).value;
    if (!std::isfinite(value) || !is_applicable(rig, metric, pose)) continue;
    const double limit = limit_at(check.code, limits_.of(check.code).value, load);
    const double here = excess(check, value, limit);
    if (here <= out.excess) continue;
    if (on_mesh && against_ideal_ && here > 1.0) {
      const double ideal = ideal_[direction][step].at(metric.id).value;
      if (std::isfinite(ideal) && excess(check, ideal, limit) > here - kEqual) continue;
    }
    out = {here, check.code};
  }
  return out;
}

HeadroomGauge::Reach HeadroomGauge::reach_of(RigRecord& rig, const RigAtRest& at_rest,
                                             Index direction) const {
  SweepRecord& record = rig.sweeps[direction];
  Reach out{kFurthest, {}};
  double before = 0.0;
  Index last = record.poses.size() - 1;
  for (Index i = 0; i < record.poses.size(); ++i) {
    PoseRecord& pose = record.poses[i];
    measure_pose(body_, at_rest, stage_.pose(*rig.system, pose.control), pose, Crossing::left_out);
    if (pose.at(MetricId::non_finite).value == 0.0) measure_pose_behaviour(stage_, rig, pose);
    const Nearest nearest = nearest_limit(rig, pose, direction, i);
    if (nearest.excess > 1.0) {
      const double from = i > 0 ? static_cast<double>(i - 1) : 0.0;
      const double share = i > 0 ? (1.0 - before) / (nearest.excess - before) : 0.0;
      out = {(from + share) / kSteps, std::string(nearest.code)};
      last = std::max<Index>(i, 1);
      break;
    }
    before = nearest.excess;
  }
  // Jumps and near-jumps on the way there.
  Sweep way = record.sweep;
  way.to_deg = way.step_deg * static_cast<double>(last);
  const FlipReport flips = search_flips(rig, way);
  const auto ends_at = [&](double factor, const char* code) {
    if (factor < out.clean) out = {factor, code};
  };
  const double whole = static_cast<double>(last) / kSteps;
  for (const Jump& jump : flips.jumps) ends_at(whole * jump.before, "BB001");
  const Check& steep = *find_check("BB002");
  for (Index i = 0; i < flips.interval_gain.size(); ++i)
    if (judge(steep, flips.interval_gain[i], limits_.of("BB002").value) == Verdict::fail)
      ends_at(static_cast<double>(i) / kSteps, "BB002");
  return out;
}

RigGauge HeadroomGauge::of(const solver::SystemSpec& spec) const {
  RigRecord rig = planned(spec);
  const RigAtRest at_rest = rig_at_rest(*rig.system);
  std::vector<Reach> reach(directions_.size());
  oneapi::tbb::parallel_for(Index{0}, reach.size(),
                            [&](Index d) { reach[d] = reach_of(rig, at_rest, d); });
  RigGauge out;
  out.least = kFurthest;
  for (Index d = 0; d < reach.size(); ++d) {
    out.clean.push_back(reach[d].clean);
    out.headroom += reach[d].clean / static_cast<double>(reach.size());
    if (reach[d].clean >= out.least) continue;
    out.least = reach[d].clean;
    out.worst = d;
    out.code = reach[d].code;
  }
  const std::vector<Points> curves = curves_of(rig);
  double sum = 0.0;
  for (Index i = 0; i < curves.size(); ++i)
    for (Index k = 0; k < kCurvePointCount; ++k) {
      const double off = glm::distance(curves[i][k], given_[i][k]);
      sum += off * off;
      out.change_most = std::max(out.change_most, off);
    }
  const double percent = 100.0 / stage_.anatomy().spine_length;
  out.change = percent * std::sqrt(sum / static_cast<double>(curves.size() * kCurvePointCount));
  out.change_most *= percent;
  return out;
}

}  // namespace backbend::validate
