#include "validate/clips/clip_judge.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>

#include "skin/character/matrix_facts.h"
#include "validate/clips/clip_frames.h"
#include "validate/judge/judge.h"
#include "validate/verdicts/booking.h"

namespace backbend::validate {
namespace {

using Index = std::size_t;

// Fewer frames have no pace to compare a step with (see find_clip_flips).
constexpr Index kLeastFrames = 5;

constexpr std::string_view kResponseCode = "BB049";

/// Whether a metric applies to a sweep of a baked clip.
bool is_applicable(const ClipRecord& record, const ClipSweepRecord& sweep, const Metric& metric) {
  if (metric.id == MetricId::gain && sweep.travel.empty()) return false;
  return is_applicable(
      metric, ClipScope{.surface = record.surface,
                        .has_corners = record.has_corners,
                        .has_drift = record.has_arms && sweep.drift_applies,
                        .has_slides = record.has_slides && sweep.range.count >= kLeastFrames});
}

/// Stretch may be intended, and a clip has no option for it: shown, never deciding.
bool decides(const Metric& metric) {
  return metric.check().decides && metric.id != MetricId::length_change;
}

Owner owner_of(const Check& check, const skin::Clip& clip) {
  return check.owner == Owner::solver || check.subject == Subject::chain ? owner_of_motion(clip)
                                                                         : check.owner;
}

Finding start_finding(const ClipContext& context, const ClipSweepRecord& sweep,
                      std::string_view code, Index pose) {
  const Check& check = *find_check(code);
  Finding finding;
  finding.code = code;
  finding.character = context.character.name;
  finding.rig = context.clip.name;
  finding.sweep = sweep.range.name;
  finding.pose = frame_text(context.clip, sweep.range, pose);
  finding.pose_index = static_cast<int>(pose);
  const Index f = sweep.range.first + pose;
  if (context.clip.frame_number[f] >= 0) {
    finding.frame = context.clip.frame_number[f];
    finding.time_s = context.clip.time[f];
  }
  finding.control_deg = sweep.poses[pose].control_deg;
  finding.limit = context.limits.of(code).value;
  finding.unit = check.unit;
  finding.owner = owner_of(check, context.clip);
  finding.verdict = Verdict::fail;
  finding.image.note = "not looked at: no pictures were made";
  finding.reproduce = context.command;
  return finding;
}

/// The jump that stands for all of one place: the widest of a single joint, the lowest on the chain
/// where several are as wide; or, where many small ones add up, what they come to, at the lowest
/// joint that turns by all of it.
const ClipJump& leading_jump(const ClipRecord& record, std::span<const ClipJump> jumps) {
  using Against = WatchedJoint::Against;
  constexpr double kAsWide = 0.9, kAddsUp = 1.15;
  const auto lowest_widest = [&](auto is_counted) {
    const ClipJump* best = nullptr;
    double widest = 0.0;
    for (const ClipJump& jump : jumps)
      if (is_counted(jump)) widest = std::max(widest, jump.size_deg);
    for (const ClipJump& jump : jumps)
      if (best == nullptr && is_counted(jump) && jump.size_deg >= kAsWide * widest) best = &jump;
    return best;
  };
  const auto is_sum = [&](const ClipJump& jump) {
    return record.watched[jump.joint].against == Against::hips;
  };
  const ClipJump* own = lowest_widest([&](const ClipJump& jump) { return !is_sum(jump); });
  const ClipJump* sum = lowest_widest(is_sum);
  if (own == nullptr) return *sum;
  return sum != nullptr && sum->size_deg > kAddsUp * own->size_deg ? *sum : *own;
}

/// Jumps of several joints between the same two frames are one event.
std::vector<Finding> flip_findings(const ClipRecord& record, const ClipContext& context,
                                   const ClipSweepRecord& sweep) {
  using Against = WatchedJoint::Against;
  std::vector<Finding> out;
  const std::span<const ClipJump> jumps = sweep.flips.jumps;
  for (Index first = 0; first < jumps.size();) {
    Index last = first;
    std::string joints;
    for (; last < jumps.size() && jumps[last].frame == jumps[first].frame; ++last) {
      const WatchedJoint& joint = record.watched[jumps[last].joint];
      if (joint.against != Against::hips)
        joints += (joints.empty() ? "" : ", ") + joint.name + " by " +
                  number_text(jumps[last].size_deg, 1) + " deg";
    }
    const ClipJump& jump = leading_jump(record, jumps.subspan(first, last - first));
    const WatchedJoint& joint = record.watched[jump.joint];
    Finding finding = start_finding(context, sweep, "BB001", jump.frame + 1);
    finding.value = jump.size_deg;
    finding.limit = jump.expected_deg;
    finding.joint = joint.name;
    finding.detail = jump.frames_out == 0   ? "jump from one frame to the next, and it stays: "
                     : jump.frames_out == 1 ? "pop for one frame, out and back: "
                                            : "pop, out and back after " +
                                                  std::to_string(jump.frames_out) + " frames: ";
    if (joint.against == Against::hips)
      finding.detail += joint.name + " by " + number_text(jump.size_deg, 1) +
                        " deg against the hips, what the joints below it add up to" +
                        (joints.empty() ? "" : " (" + joints + ")");
    else
      finding.detail += joints;
    if (joint.against == Against::world) finding.detail += ", in the world";
    finding.detail += "; the motion around explains " + number_text(jump.expected_deg, 1) + " deg";
    finding.geometry["before_deg"] = sweep.poses[jump.frame].control_deg;
    finding.geometry["after_deg"] = finding.control_deg;
    finding.geometry["frames_out"] = static_cast<double>(jump.frames_out);
    finding.geometry["joints"] = static_cast<double>(last - first);
    out.push_back(std::move(finding));
    first = last;
  }
  return out;
}

/// Whether a pose ends an interval that a jump makes, there or back.
bool is_beside_jump(const ClipSweepRecord& sweep, Index pose) {
  return std::ranges::any_of(sweep.flips.jumps, [&](const ClipJump& jump) {
    return pose >= jump.frame && pose <= jump.frame + jump.frames_out + 1;
  });
}

std::optional<Index> worst_failing(const ClipSweepRecord& sweep, const Metric& metric,
                                   double limit) {
  const Check& check = metric.check();
  std::optional<Index> worst;
  double most = 0.0;
  for (Index i = 0; i < sweep.poses.size(); ++i) {
    const double value = sweep.poses[i].at(metric.id).value;
    if (judge(check, value, limit) != Verdict::fail) continue;
    // The gain of an interval that holds a jump is that jump, which is a finding already.
    if (metric.id == MetricId::gain && is_beside_jump(sweep, i)) continue;
    const double here = excess(check, value, limit);
    // Of equal values up to rounding the first frame is the worst.
    if (!worst || here > most * (1.0 + 1e-3)) {
      worst = i;
      most = here;
    }
  }
  return worst;
}

Finding metric_finding(const ClipRecord& record, const ClipContext& context,
                       const ClipSweepRecord& sweep, const Metric& metric, Index pose) {
  const Check& check = metric.check();
  Finding finding = start_finding(context, sweep, check.code, pose);
  const Measured& measured = sweep.poses[pose].at(metric.id);
  finding.value = measured.value;
  set_place(metric, measured.place, context.system.joint_names(), finding);
  const bool watched = metric.id == MetricId::arm_shift || metric.id == MetricId::arm_drift;
  if (watched && measured.place >= 0)
    finding.joint = record.watched[static_cast<Index>(measured.place)].name;
  if (!decides(metric)) finding.verdict = Verdict::stress;
  std::size_t frames = 0;
  for (const PoseRecord& each : sweep.poses)
    frames += judge(check, each.at(metric.id).value, finding.limit) == Verdict::fail;
  finding.detail = "beyond the limit in " + std::to_string(frames) + " of " +
                   std::to_string(sweep.poses.size()) + " frames";
  if (metric.id == MetricId::arm_shift)
    finding.detail = finding.joint + " slides on its parent by " + number_text(finding.value, 2) +
                     " % of the spine (" +
                     number_text(10.0 * finding.value * context.anatomy.spine_length, 1) +
                     " mm); " + finding.detail;
  if (metric.id == MetricId::arm_drift)
    finding.detail = finding.joint + " turns by " + number_text(finding.value, 2) +
                     " deg against what carries it, with no arm control moved; " + finding.detail;
  if (metric.id == MetricId::length_change)
    finding.detail += "; no option says how much stretch is meant";
  return finding;
}

/// A joint that leaves its share of the bend over some frames of a sweep, or turns too far and
/// other joints turn back: kink, or roll where it turns about its own bone.
std::optional<Finding> share_finding(const ClipRecord& record, const ClipContext& context,
                                     const ClipSweepRecord& sweep) {
  const auto over = [](const ShareExcess& each) { return each.deg - each.limit_deg; };
  Index worst = 0;
  for (Index i = 1; i < sweep.shares.size(); ++i)
    if (over(sweep.shares[i]) > over(sweep.shares[worst]) + 1e-3) worst = i;
  if (sweep.shares.empty() || !(over(sweep.shares[worst]) > 0.0)) return std::nullopt;
  const ShareExcess& excess = sweep.shares[worst];
  const auto k = static_cast<Index>(record.share_joint[static_cast<Index>(excess.joint)]);
  Finding finding = start_finding(context, sweep, "BB010", worst);
  finding.value = excess.deg;
  finding.limit = excess.limit_deg;
  finding.joint = record.watched[k].name;
  const auto place = [&](Index joint) {
    const std::vector<int>& spine = context.anatomy.spine;
    return skin::origin(
        context.character.nodes[static_cast<Index>(spine[std::min(joint, spine.size() - 1)])]
            .world_from_node);
  };
  const auto frames = std::count_if(sweep.shares.begin(), sweep.shares.end(),
                                    [&](const ShareExcess& each) { return over(each) > 0.0; });
  finding.detail = finding.joint + words_of(excess, place(k + 1) - place(k)) + ", in " +
                   std::to_string(frames) + " of " + std::to_string(sweep.shares.size()) +
                   " frames";
  finding.geometry["frames"] = static_cast<double>(frames);
  return finding;
}

/// A channel whose control does not turn the chest as the channel's name says: the mapping names
/// another control, another axis or the other sign, or the rig does not carry the turn to the
/// chest.
std::optional<Finding> response_finding(const ClipContext& context, const ClipSweepRecord& sweep) {
  if (!sweep.response) return std::nullopt;
  const ControlResponse& response = *sweep.response;
  const double limit = context.limits.of(kResponseCode).value;
  if (judge(*find_check(kResponseCode), response.share(), limit) != Verdict::fail)
    return std::nullopt;
  Finding finding = start_finding(context, sweep, kResponseCode, response.pose);
  finding.owner = Owner::input;
  finding.value = response.share();
  const skin::Anatomy& anatomy = context.anatomy;
  finding.joint =
      context.character.nodes[static_cast<Index>(anatomy.spine[anatomy.chest_index])].name;
  const double asked = std::abs(response.asked_deg), least = limit * asked;
  finding.detail = "of " + number_text(asked, 1) + " deg of " + response.channel + ", " +
                   number_text(response.share() * asked, 1) + " arrive at the chest";
  finding.detail += response.arrived_deg * response.asked_deg < -least * asked
                        ? ": it turns the other way round"
                    : response.other_deg > least
                        ? ", and " + number_text(response.other_deg, 1) + " deg about other axes"
                        : "";
  finding.detail += "; see which control and which sign the mapping gives this channel";
  finding.geometry["asked_deg"] = response.asked_deg;
  finding.geometry["arrived_deg"] = response.arrived_deg;
  finding.geometry["other_deg"] = response.other_deg;
  return finding;
}

const ClipSweepRecord& longest_sweep(const ClipRecord& record) {
  return *std::max_element(record.sweeps.begin(), record.sweeps.end(),
                           [](const ClipSweepRecord& a, const ClipSweepRecord& b) {
                             return a.range.count < b.range.count;
                           });
}

}  // namespace

Owner owner_of_motion(const skin::Clip& clip) {
  return clip.control.empty() && !clip.joint.empty() ? Owner::motion : Owner::rig;
}

LimitSet clip_limits() {
  LimitSet limits;
  const auto set = [&](std::string_view code, double value, const char* reason) {
    limits.set(code, {value, LimitLayer::builtin, "baked clips", "backbend", reason});
  };
  set("BB001", ClipSettings{}.smallest_deg,
      "frames cannot be bisected: a step is a jump where it leaves the prediction of the frames on "
      "both sides by 7 deg (5 where the clip holds its controls), and by three times what the "
      "paces "
      "around it vary by; captured dance and acrobatics reach 2.5 times");
  set("BB010", 30.0,
      "no curve is known that the chain should follow; a joint is held against its neighbours, "
      "and captured acrobatics on spines of four to six joints bend one by up to 17 deg more than "
      "those beside it, a keyed attack by 27");
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
    if (const auto response = response_finding(context, sweep)) findings.push_back(*response);
    const std::optional<Finding> share = share_finding(record, context, sweep);
    if (share) findings.push_back(*share);
    for (const Metric& metric : metric_table()) {
      const Check& check = metric.check();
      if (metric.id == MetricId::chain_kink && share) continue;  // the same, with its size
      if (!check.decides || !is_applicable(record, sweep, metric)) continue;
      if (metric.id == MetricId::non_finite && !sweep.flips.finite) continue;  // a finding already
      const auto worst = worst_failing(sweep, metric, context.limits.of(check.code).value);
      if (worst) findings.push_back(metric_finding(record, context, sweep, metric, *worst));
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
    const Metric* metric = metric_of(finding.code);
    if (check.subject != Subject::mesh || metric == nullptr) continue;
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
    facts.ideal = clean.at(metric->id).value;
    facts.proxy = std::numeric_limits<double>::quiet_NaN();
    facts.infeasible = clean.at(MetricId::feasibility).value;
    Booking booking = book_mesh_finding(check, finding.limit, facts);
    // A clip moves the limbs on purpose, and what turns over at their roots turns over under the
    // even bend as well. Areas add up: the spine's own share is what is left.
    if (finding.code == "BB033" && booking.owner == Owner::solver &&
        facts.value - facts.ideal <= finding.limit)
      booking = {booking.verdict, Owner::weights, false};
    finding.owner = booking.owner == Owner::solver ? owner_of_motion(context.clip) : booking.owner;
    // Captured or keyed motion bends the skin as intended: it is not compared with an even bend.
    if (finding.owner == Owner::motion) booking.decides = false;
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
    else  // a held pose beside real motion is fine; a clip of held poses alone is a gap
      ++(any ? flips.not_applicable : flips.not_measured);
  }
  out.push_back(flips);
  Coverage responses{std::string(kResponseCode), 0, 0, 0, 0};
  for (const ClipSweepRecord& sweep : record.sweeps) {
    ++responses.planned;
    ++(sweep.response ? responses.measured : responses.not_applicable);
  }
  out.push_back(responses);
  for (const Metric& metric : metric_table()) {
    const Check& check = metric.check();
    if (check.subject == Subject::mesh && !record.has_mesh) continue;
    Coverage coverage{std::string(check.code), 0, 0, 0, 0};
    for (const ClipSweepRecord& sweep : record.sweeps)
      for (const PoseRecord& pose : sweep.poses) {
        ++coverage.planned;
        if (!is_applicable(record, sweep, metric))
          ++coverage.not_applicable;
        else
          ++(std::isfinite(pose.at(metric.id).value) ? coverage.measured : coverage.not_measured);
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
    for (const Metric& metric : metric_table()) {
      std::vector<double> values;
      for (const PoseRecord& pose : sweep.poses) values.push_back(pose.at(metric.id).value);
      if (std::none_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); }))
        continue;
      const std::string name(metric.name);
      series.metric[name] = std::move(values);
      series.metric_unit[name] = metric.check().unit;
      series.metric_limit[name] = limits.of(metric.code).value;
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
  const Index count = record.watched.size(), joint = context.anatomy.chest_index / 2 + 1;
  const Index at = sweep.range.count / 2;
  result.joint = record.watched[joint].name;
  const int number = context.clip.frame_number[sweep.range.first + at];
  result.expected_deg = number < 0 ? static_cast<double>(at) : number;
  result.found_deg = std::nan("");
  std::vector<glm::dquat> turns = watched_turns(context.body, record.watched, sweep.range);
  // About the bone, as up vectors and hemispheres flip.
  const solver::SpinePose& rest = context.system.rest();
  const Index bone = std::min(joint, rest.position.size() - 2);
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

}  // namespace backbend::validate
