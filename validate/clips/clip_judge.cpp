#include "validate/clips/clip_judge.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "validate/run/judge.h"
#include "validate/verdicts/booking.h"

namespace backbend::validate {
namespace {

using Index = std::size_t;

// Fewer frames have no pace to compare a step with (see find_clip_flips).
constexpr Index kLeastFrames = 5;

/// What a baked clip says anything about.
bool is_applicable(const ClipRecord& record, const ClipSweepRecord& sweep, MetricId metric) {
  switch (metric) {
    case MetricId::gain:
    case MetricId::flip_margin:
    case MetricId::lost_twist:
    case MetricId::end_gap:
    case MetricId::arm_slide:          // arms move on purpose
    case MetricId::chain_twist_jump:   // nor is a twist known that the chain should carry
    case MetricId::self_intersection:  // limbs pass close by on purpose
    case MetricId::predictability:
    case MetricId::mirror:  // nobody asks a clip for another pose
    case MetricId::return_to_rest:
    case MetricId::range_of_motion:
      return false;
    case MetricId::chain_kink:
      return record.has_corners;
    case MetricId::arm_drift:
      return record.has_arms && record.clavicles_rest;
    case MetricId::arm_shift:
      return record.has_arms && sweep.range.count >= kLeastFrames;
    case MetricId::volume:
      return !record.open_mesh;
    default:
      return true;
  }
}

/// Stretch may be meant, and no option of a clip says by how much: shown, never deciding.
bool decides(MetricId metric, const Check& check) {
  return check.decides && metric != MetricId::length_change;
}

std::string frame_text(const ClipContext& context, const ClipSweepRecord& sweep, Index pose) {
  std::string text;
  if (!sweep.control.empty())
    text = sweep.control + " " + number_text(sweep.poses[pose].control_deg, 3) + ", ";
  return text + "frame " + std::to_string(kFirstFrame + static_cast<int>(pose)) + " (" +
         number_text(context.clip.time[sweep.range.first + pose], 3) + " s)";
}

Finding start_finding(const ClipContext& context, const ClipSweepRecord& sweep,
                      std::string_view code, Index pose) {
  const Check& check = *find_check(code);
  Finding finding;
  finding.code = code;
  finding.character = context.character.name;
  finding.rig = context.clip.name;
  finding.sweep = sweep.range.name;
  finding.pose = frame_text(context, sweep, pose);
  finding.pose_index = static_cast<int>(pose);
  finding.control_deg = sweep.poses[pose].control_deg;
  finding.limit = context.limits.of(code).value;
  finding.unit = check.unit;
  finding.owner = check.owner;
  finding.verdict = Verdict::fail;
  finding.geometry["time_s"] = context.clip.time[sweep.range.first + pose];
  finding.image.note = "pictures of clips are shown, not measured";
  finding.reproduce = context.command;
  return finding;
}

/// Jumps of several joints between the same two frames are one event: the widest is its finding.
std::vector<Finding> flip_findings(const ClipRecord& record, const ClipContext& context,
                                   const ClipSweepRecord& sweep) {
  std::vector<Finding> out;
  const std::vector<ClipJump>& jumps = sweep.flips.jumps;
  for (Index first = 0; first < jumps.size();) {
    Index last = first, widest = first;
    std::string joints;
    for (; last < jumps.size() && jumps[last].frame == jumps[first].frame; ++last) {
      if (jumps[last].size_deg > jumps[widest].size_deg) widest = last;
      joints += (joints.empty() ? "" : ", ") + record.watched[jumps[last].joint].name + " by " +
                number_text(jumps[last].size_deg, 1) + " deg";
    }
    const ClipJump& jump = jumps[widest];
    Finding finding = start_finding(context, sweep, "BB001", jump.frame + 1);
    finding.value = jump.size_deg;
    finding.limit = jump.expected_deg;
    finding.joint = record.watched[jump.joint].name;
    finding.detail = "jump from one frame to the next: " + joints +
                     "; the motion around explains " + number_text(jump.expected_deg, 1) + " deg";
    finding.geometry["before_deg"] = sweep.poses[jump.frame].control_deg;
    finding.geometry["after_deg"] = finding.control_deg;
    finding.geometry["joints"] = static_cast<double>(last - first);
    out.push_back(std::move(finding));
    first = last;
  }
  return out;
}

std::optional<Index> worst_failing(const ClipSweepRecord& sweep, MetricId metric,
                                   const Check& check, double limit) {
  std::optional<Index> worst;
  double most = 0.0;
  for (Index i = 0; i < sweep.poses.size(); ++i) {
    const double value = sweep.poses[i].at(metric).value;
    if (judge(check, value, limit) != Verdict::fail) continue;
    const double here = excess(check, value, limit);
    if (!worst || here > most) {
      worst = i;
      most = here;
    }
  }
  return worst;
}

Finding metric_finding(const ClipContext& context, const ClipSweepRecord& sweep, MetricId metric,
                       const Check& check, Index pose) {
  Finding finding = start_finding(context, sweep, check.code, pose);
  const Measured& measured = sweep.poses[pose].at(metric);
  finding.value = measured.value;
  set_place(metric, measured.place, context.system.joint_names(), finding);
  if (!decides(metric, check)) finding.verdict = Verdict::stress;
  std::size_t frames = 0;
  for (const PoseRecord& each : sweep.poses)
    frames += judge(check, each.at(metric).value, finding.limit) == Verdict::fail;
  finding.detail = "beyond the limit in " + std::to_string(frames) + " of " +
                   std::to_string(sweep.poses.size()) + " frames";
  if (metric == MetricId::length_change)
    finding.detail += "; no option says how much stretch is meant";
  return finding;
}

std::optional<MetricId> metric_of(const std::string& code) {
  for (Index m = 0; m < kMetricCount; ++m)
    if (pose_metrics()[m].code == code) return static_cast<MetricId>(m);
  return std::nullopt;
}

const ClipSweepRecord& longest_sweep(const ClipRecord& record) {
  return *std::max_element(record.sweeps.begin(), record.sweeps.end(),
                           [](const ClipSweepRecord& a, const ClipSweepRecord& b) {
                             return a.range.count < b.range.count;
                           });
}

}  // namespace

LimitSet clip_limits() {
  LimitSet limits;
  const auto set = [&](std::string_view code, double value, const char* reason) {
    limits.set(code, {value, LimitLayer::builtin, "baked clips", "backbend", reason});
  };
  set("BB001", ClipSettings{}.smallest_deg,
      "frames cannot be bisected: captured shoulders and necks change their pace by up to 33 deg "
      "from frame to frame, interpolation jumps by 60 and more; the limit rises where the clip "
      "itself moves faster");
  set("BB010", 15.0,
      "no curve is known that the chain should follow; a joint is held against its neighbours, "
      "and captured acrobatics bend three-joint spines unevenly by up to 8 deg");
  return limits;
}

std::vector<Finding> judge_clip(const ClipRecord& record, const ClipContext& context) {
  std::vector<Finding> findings;
  for (const ClipSweepRecord& sweep : record.sweeps) {
    for (Finding& finding : flip_findings(record, context, sweep))
      findings.push_back(std::move(finding));
    if (!sweep.flips.finite) {
      Finding finding = start_finding(context, sweep, "BB050", sweep.flips.not_finite_frame);
      finding.value = 1.0;
      finding.detail = "a joint's matrix has no rotation: mirrored, collapsed or not finite";
      findings.push_back(std::move(finding));
    }
    for (Index m = 0; m < kMetricCount; ++m) {
      const auto metric = static_cast<MetricId>(m);
      const Check& check = *find_check(pose_metrics()[m].code);
      if (!check.decides || !is_applicable(record, sweep, metric)) continue;
      if (metric == MetricId::non_finite && !sweep.flips.finite) continue;  // a finding already
      const auto worst = worst_failing(sweep, metric, check, context.limits.of(check.code).value);
      if (worst) findings.push_back(metric_finding(context, sweep, metric, check, *worst));
    }
  }
  std::stable_sort(findings.begin(), findings.end(), [](const Finding& a, const Finding& b) {
    if ((a.verdict == Verdict::fail) != (b.verdict == Verdict::fail))
      return a.verdict == Verdict::fail;
    return excess(*find_check(a.code), a.value, a.limit) >
           excess(*find_check(b.code), b.value, b.limit);
  });
  return findings;
}

void book_clip_owners(const ClipContext& context, const ClipRecord& record,
                      std::vector<Finding>& findings) {
  if (context.metrics == nullptr) return;
  for (Finding& finding : findings) {
    const Check& check = *find_check(finding.code);
    const auto metric = metric_of(finding.code);
    if (check.subject != Subject::mesh || !metric) continue;
    const auto sweep =
        std::find_if(record.sweeps.begin(), record.sweeps.end(),
                     [&](const ClipSweepRecord& each) { return each.range.name == finding.sweep; });
    const Index frame = sweep->range.first + static_cast<Index>(finding.pose_index);
    const std::vector<glm::dmat4> even =
        even_bend(context.character, context.anatomy, context.system, context.body, frame);
    const ClipSystem ideal(context.character, context.anatomy, even);
    PosedCharacter posed;
    posed.spine = ideal.pose(0);
    posed.mesh = context.body.blended(even);
    PoseRecord clean;
    clean.control = {0.0};
    clean.body.twist = ideal.twist_deg(0);
    measure_pose(*context.metrics, rig_at_rest(ideal), posed, clean);
    MeshContext facts;
    facts.value = finding.value;
    facts.ideal = clean.at(*metric).value;
    facts.proxy = std::numeric_limits<double>::quiet_NaN();
    facts.infeasible = clean.at(MetricId::feasibility).value;
    Booking booking = book_mesh_finding(check, finding.limit, facts);
    // A clip moves the limbs on purpose, and what turns over at their roots turns over under the
    // even bend as well. Areas add up: the spine's own share is what is left.
    if (finding.code == "BB033" && booking.owner == Owner::solver &&
        facts.value - facts.ideal <= finding.limit)
      booking = {booking.verdict, Owner::weights, false};
    finding.owner = booking.owner;
    if (!booking.decides) finding.verdict = Verdict::stress;
    finding.geometry["ideal"] = facts.ideal;
    finding.detail += "; an even bend with the same ends gives " + number_text(facts.ideal, 3);
    if (booking.owner == Owner::pose)
      finding.detail += "; too thick to bend this far, no fault of the rig";
  }
  std::stable_partition(findings.begin(), findings.end(),
                        [](const Finding& finding) { return finding.verdict == Verdict::fail; });
}

std::vector<Coverage> clip_coverage(const ClipRecord& record) {
  std::vector<Coverage> out;
  Coverage flips{"BB001", 0, 0, 0, 0};
  const bool any =
      std::any_of(record.sweeps.begin(), record.sweeps.end(),
                  [](const ClipSweepRecord& sweep) { return sweep.range.count >= kLeastFrames; });
  for (const ClipSweepRecord& sweep : record.sweeps) {
    ++flips.planned;
    if (!sweep.flips.finite)
      ++flips.not_measured;
    else if (sweep.range.count >= kLeastFrames)
      ++flips.measured;
    else  // a held pose beside real motion is no gap; nothing but held poses is one
      ++(any ? flips.not_applicable : flips.not_measured);
  }
  out.push_back(flips);
  for (Index m = 0; m < kMetricCount; ++m) {
    const auto metric = static_cast<MetricId>(m);
    const Check& check = *find_check(pose_metrics()[m].code);
    if (check.subject == Subject::mesh && !record.has_mesh) continue;
    Coverage coverage{std::string(check.code), 0, 0, 0, 0};
    for (const ClipSweepRecord& sweep : record.sweeps)
      for (const PoseRecord& pose : sweep.poses) {
        ++coverage.planned;
        if (!is_applicable(record, sweep, metric))
          ++coverage.not_applicable;
        else
          ++(std::isfinite(pose.at(metric).value) ? coverage.measured : coverage.not_measured);
      }
    out.push_back(coverage);
  }
  std::sort(out.begin(), out.end(),
            [](const Coverage& a, const Coverage& b) { return a.code < b.code; });
  return out;
}

std::vector<SweepSeries> clip_series(const ClipRecord& record, const LimitSet& limits) {
  std::vector<SweepSeries> out;
  for (const ClipSweepRecord& sweep : record.sweeps) {
    SweepSeries series;
    series.sweep = sweep.range.name;
    series.channel = sweep.control.empty() ? "frame" : sweep.control;
    for (const PoseRecord& pose : sweep.poses) series.control_deg.push_back(pose.control_deg);
    for (Index m = 0; m < kMetricCount; ++m) {
      const MetricInfo& info = pose_metrics()[m];
      std::vector<double> values;
      for (const PoseRecord& pose : sweep.poses) values.push_back(pose.metric[m].value);
      if (std::none_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); }))
        continue;
      const std::string name(info.name);
      series.metric[name] = std::move(values);
      series.metric_unit[name] = find_check(info.code)->unit;
      series.metric_limit[name] = limits.of(info.code).value;
    }
    out.push_back(std::move(series));
  }
  return out;
}

CanaryResult clip_canary(const ClipRecord& record, const ClipContext& context) {
  const ClipSweepRecord& sweep = longest_sweep(record);
  CanaryResult result;
  result.rig = "clip_half_turn";
  result.code = "BB001";
  const Index count = record.watched.size(), joint = context.anatomy.chest_index / 2;
  const Index at = sweep.range.count / 2;
  result.joint = record.watched[joint].name;
  result.expected_deg = kFirstFrame + static_cast<double>(at);
  result.found_deg = std::nan("");
  std::vector<glm::dquat> turns = watched_turns(context.body, record.watched, sweep.range);
  // About the bone, as up vectors and hemispheres flip.
  const solver::SpinePose& rest = context.system.rest();
  const Index bone = std::min(joint + 1, rest.position.size() - 2);
  const glm::dquat flip =
      rotation(glm::normalize(rest.position[bone + 1] - rest.position[bone]) * kPi);
  for (Index f = at; f < sweep.range.count; ++f)
    turns[f * count + joint] = turns[f * count + joint] * flip;
  const auto begin = context.clip.time.begin() + static_cast<std::ptrdiff_t>(sweep.range.first);
  const std::vector<double> time(begin, begin + static_cast<std::ptrdiff_t>(sweep.range.count));
  const ClipReport report = find_clip_flips({count, turns, time});
  const auto here = [&](const ClipJump& jump) {
    return jump.joint == joint && jump.frame + 1 == at;
  };
  result.found = std::any_of(report.jumps.begin(), report.jumps.end(), here);
  if (result.found) result.found_deg = result.expected_deg;
  result.twin_clean = std::none_of(sweep.flips.jumps.begin(), sweep.flips.jumps.end(), here);
  result.detail = "half a turn of " + result.joint + " from frame " +
                  number_text(result.expected_deg, 0) + " on " +
                  (result.found ? "is found" : "is not found") +
                  (result.twin_clean ? "" : "; the clip jumps there by itself");
  return result;
}

std::string clip_sensitivity(const ClipRecord& record) {
  double least = std::numeric_limits<double>::infinity(), most = 0.0;
  std::string busiest;
  for (const ClipSweepRecord& sweep : record.sweeps)
    for (Index j = 0; j < sweep.flips.detectable_deg.size(); ++j) {
      const double deg = sweep.flips.detectable_deg[j];
      if (!std::isfinite(deg)) continue;
      least = std::min(least, deg);
      if (deg > most) {
        most = deg;
        busiest = record.watched[j].name;
      }
    }
  if (busiest.empty()) return "flips: no sweep has the five frames that tell a jump from motion";
  return "flips: jumps from " + number_text(least, 1) + " deg in one frame step are found; " +
         busiest + ", the busiest joint, hides those below " + number_text(most, 1);
}

}  // namespace backbend::validate
