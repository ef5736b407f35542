#include "validate/judge/judge.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <set>
#include <utility>

#include "validate/judge/judge_recorded.h"
#include "validate/live/external_rig.h"
#include "validate/sweeps/external_spec.h"
#include "validate/text/shell_word.h"
#include "validate/verdicts/booking.h"

namespace backbend::validate {

std::string command_for(const RigRecord& rig, const std::string& character, DrivenChain chain,
                        const PoseDegrees& pose) {
  std::string channels;
  for (const std::string_view channel : kChannels) {
    const double value = *pose.find(channel);
    if (value == 0.0) continue;
    channels += (channels.empty() ? "" : ",") + std::string(channel) + "=" + number_text(value, 6);
  }
  // The rig `neck` drives the neck by itself, unless joints were named.
  const bool neck = chain == DrivenChain::neck;
  const std::string driven =
      neck || rig.plan.spec.system == "neck" ? neck ? " --chain neck" : " --chain spine" : "";
  std::string words = shell_word(rig_text(rig.plan.spec));
  if (is_external(rig.plan.spec)) {
    const std::string map = external_spec(rig.plan.spec).map;
    if (!map.empty()) words += " --map " + shell_word(map);
  }
  return "backbend render " + character + driven + " --rig " + words + " --mapping " +
         std::string(mapping_name(rig.mapping)) + (channels.empty() ? "" : " --pose " + channels);
}

double compound_load(const Envelope& envelope, const PoseDegrees& pose) {
  if (envelope.whole_sweep || !envelope.contains(pose)) return 1.0;
  double sum = 0.0;
  for (const std::string_view channel : kBendChannels)
    if (const double needs = envelope.needs(channel); needs > 0.0)
      sum += *pose.find(channel) * *pose.find(channel) / (needs * needs);
  return std::max(1.0, std::sqrt(sum));
}

double limit_at(std::string_view code, double limit, double load) {
  const Metric* metric = metric_of(code);
  if (metric == nullptr || metric->growth == Growth::none) return limit;
  const double factor = metric->growth == Growth::with_square ? load * load : load;
  // Of a share that is kept, what is lost grows.
  return metric->check().sense == Sense::at_least ? 1.0 - (1.0 - limit) * factor : limit * factor;
}

Finding start_finding(const RigRecord& rig, const JudgeContext& context, const SweepRecord& sweep,
                      std::string_view code, const PoseDegrees& pose, double control_deg) {
  const Check& check = *find_check(code);
  Finding finding;
  finding.code = code;
  finding.at.sweep = static_cast<int>(&sweep - rig.sweeps.data());
  finding.character = context.stage.character().name;
  finding.rig = rig.plan.name;
  finding.mapping = rig.mapping_text();
  finding.sweep = sweep.sweep.name;
  finding.pose = pose.text();
  finding.control_deg = control_deg;
  finding.limit = context.limits.of(code).value;
  finding.unit = check.unit;
  finding.owner = check.owner;
  finding.inside_envelope = context.envelope.contains(pose);
  finding.verdict = finding.inside_envelope ? Verdict::fail : Verdict::stress;
  if (!rig.recording) {
    finding.reproduce = command_for(rig, context.character, context.stage.chain(), pose);
    return finding;
  }
  if (check.owner == Owner::solver || check.subject == Subject::chain)
    finding.owner = rig.recording->owner;
  finding.reproduce = rig.recording->command;
  finding.image.note = "not looked at: no pictures were made";
  return finding;
}

Finding start_finding(const RigRecord& rig, const JudgeContext& context, const SweepRecord& sweep,
                      std::string_view code, std::size_t index) {
  const PoseRecord& pose = sweep.poses[index];
  Finding finding = start_finding(rig, context, sweep, code, pose.body, pose.control_deg);
  finding.at.pose = static_cast<int>(index);
  if (rig.recording) {
    finding.pose = frame_text(sweep, index);
    // Which of a file's animations it is; a sweep of a channel says so itself.
    if (rig.sweeps.size() > 1 && sweep.sweep.channel.empty())
      finding.pose = sweep.sweep.name + ", " + finding.pose;
  }
  finding.frame = pose.frame;
  if (pose.frame) finding.time_s = pose.time_s;
  return finding;
}

const SweepRecord* sweep_of(const RigRecord& rig, const Finding& finding) {
  return finding.at.sweep < 0 ? nullptr : &rig.sweeps[static_cast<std::size_t>(finding.at.sweep)];
}

namespace {

std::string joint_list(const RigRecord& rig, const Jump& jump) {
  std::string text;
  for (const JointJump& joint : jump.joints) {
    text += (text.empty() ? "" : ", ") + joint_name(rig, static_cast<int>(joint.joint));
  }
  return text;
}

Finding flip_finding(const RigRecord& rig, const JudgeContext& context, const SweepRecord& sweep,
                     const Jump& jump) {
  const double span = sweep.sweep.to_deg - sweep.sweep.from_deg;
  const double control = sweep.sweep.from_deg + span * jump.t;
  Finding finding =
      start_finding(rig, context, sweep, "BB001", sweep.sweep.pose_at(control), control);
  finding.value = jump.size_deg();
  if (jump.kind == FlipClass::pop) {
    finding.value = 100.0 * jump.joints.front().shift;
    finding.limit = 100.0 * FlipSettings{}.smallest_shift;
    finding.unit = "% of spine";
  }
  if (!jump.joints.empty())
    finding.joint = joint_name(rig, static_cast<int>(jump.joints.front().joint));
  finding.detail = std::string(name_of(jump.kind)) + ": " + joint_list(rig, jump) + " by " +
                   number_text(finding.value, 1) + " " + finding.unit + " at " +
                   sweep.sweep.channel + " " + number_text(control, 3);
  finding.geometry["before_deg"] = sweep.sweep.from_deg + span * jump.before;
  finding.geometry["after_deg"] = sweep.sweep.from_deg + span * jump.after;
  finding.geometry["joints"] = static_cast<double>(jump.joints.size());
  if (!jump.joints.empty())
    finding.geometry["axis_to_bone_deg"] = jump.joints.front().axis_to_bone_deg;
  return finding;
}

std::string name_at(const std::vector<std::string>& names, int place) {
  return place >= 0 && place < static_cast<int>(names.size())
             ? names[static_cast<std::size_t>(place)]
             : "";
}

/// The body is too thick for the pose, or nearly so, for this check to judge weights by it.
bool is_infeasible(const Check& check, const PoseRecord& pose) {
  return pose.at(MetricId::feasibility).value >= infeasible_from(check);
}

/// Whether the gain of a pose is that of a jump, which is a finding already. A rig's intervals are
/// cut where it jumps, a recording's are not.
bool is_of_jump(const RigRecord& rig, const SweepRecord& sweep, std::size_t pose) {
  if (!rig.recording) return !sweep.flips.jumps.empty();
  return std::ranges::any_of(sweep.flips.jumps, [&](const Jump& jump) {
    return std::ranges::any_of(jump.joints, [&](const JointJump& joint) {
      return pose >= jump.pose && pose <= jump.pose + joint.frames_out + 1;
    });
  });
}

/// The worst pose among those (inside or beyond the envelope) that fail. `feasible`: only those
/// that the body is not too thick for, so that an infeasible pose hides none of them.
std::optional<std::size_t> worst_failing(const RigRecord& rig, const SweepRecord& sweep,
                                         const Metric& metric, const JudgeContext& context,
                                         bool inside, bool feasible) {
  // Of equal values up to rounding a recording's first frame is the worst.
  const double worse_by = rig.recording ? 1.0 + 1e-3 : 1.0;
  const Check& check = metric.check();
  const double single = context.limits.of(check.code).value;
  std::optional<std::size_t> worst;
  double most = 0.0;
  for (std::size_t i = 0; i < sweep.poses.size(); ++i) {
    const PoseRecord& pose = sweep.poses[i];
    if (pose.inside != inside || !is_applicable(rig, metric, pose)) continue;
    if (feasible && is_infeasible(check, pose)) continue;
    const double value = pose.at(metric.id).value;
    const double limit = limit_at(check.code, single, compound_load(context.envelope, pose.body));
    if (judge(check, value, limit) != Verdict::fail) continue;
    if (metric.id == MetricId::gain && is_of_jump(rig, sweep, i)) continue;
    const double here = excess(check, value, limit);
    if (worst && !(here > most * worse_by)) continue;
    worst = i;
    most = here;
  }
  return worst;
}

double first_failing_deg(const RigRecord& rig, const SweepRecord& sweep, const Metric& metric,
                         const JudgeContext& context) {
  const Check& check = metric.check();
  const double single = context.limits.of(check.code).value;
  double first = std::numeric_limits<double>::quiet_NaN();
  for (const PoseRecord& pose : sweep.poses) {
    const double limit = limit_at(check.code, single, compound_load(context.envelope, pose.body));
    if (!is_applicable(rig, metric, pose) ||
        judge(check, pose.at(metric.id).value, limit) != Verdict::fail)
      continue;
    if (std::isnan(first) || std::abs(pose.control_deg) < std::abs(first)) first = pose.control_deg;
  }
  return first;
}

std::string drift_story(const PoseRecord& pose) {
  return "twist " + number_text(pose.arms.twist_deg, 2) + " deg, aim " +
         number_text(pose.arms.aim_deg, 2) + " deg, shift " +
         number_text(100.0 * pose.arms.shift, 2) + " % of spine";
}

Finding metric_finding(const RigRecord& rig, const JudgeContext& context, const SweepRecord& sweep,
                       const Metric& metric, std::size_t index) {
  const Check& check = metric.check();
  const PoseRecord& pose = sweep.poses[index];
  Finding finding = start_finding(rig, context, sweep, check.code, index);
  finding.value = pose.at(metric.id).value;
  set_place(metric, pose.at(metric.id).place, rig.system->joint_names(), finding);
  if (rig.recording) {
    describe_recorded(rig, context, sweep, metric, finding);
    return finding;
  }
  const double single = finding.limit, load = compound_load(context.envelope, pose.body);
  finding.limit = limit_at(check.code, single, load);
  finding.geometry["first_deg"] = first_failing_deg(rig, sweep, metric, context);
  finding.detail = "beyond the limit from " + sweep.sweep.channel + " " +
                   number_text(finding.geometry["first_deg"], 2);
  if (finding.limit != single)
    finding.detail += " (limit " + number_text(single, 3) + " at the end of one channel, " +
                      number_text(finding.limit, 3) + " in this compound pose)";
  if (metric.id == MetricId::arm_drift || metric.id == MetricId::arm_shift) {
    finding.detail += "; " + drift_story(pose);
    finding.geometry["twist_deg"] = pose.arms.twist_deg;
    finding.geometry["aim_deg"] = pose.arms.aim_deg;
    finding.geometry["shift_percent"] = 100.0 * pose.arms.shift;
  }
  return finding;
}

/// A joint's own bone, at rest. A recording's spine is known up to the neck.
glm::dvec3 bone_at_rest(const RigRecord& rig, const JudgeContext& context, std::size_t joint) {
  const std::vector<glm::dvec3>& place = rig.system->rest().position;
  if (!rig.recording) {
    const std::size_t below = std::min(joint, place.size() - 2);
    return place[below + 1] - place[below];
  }
  const std::vector<int>& spine = context.stage.anatomy().spine;
  const auto at = [&](std::size_t k) {
    const int node = spine[std::min(k, spine.size() - 1)];
    return glm::dvec3(
        context.stage.character().nodes[static_cast<std::size_t>(node)].world_from_node[3]);
  };
  return at(joint + 1) - at(joint);
}

}  // namespace

void set_response(const ChannelResponse& response, Finding& finding) {
  finding.value = response.share();
  finding.geometry["asked_deg"] = response.asked_deg;
  finding.geometry["arrived_deg"] = response.arrived_deg;
  finding.geometry["other_deg"] = response.other_deg;
}

std::string joint_name(const RigRecord& rig, int joint) {
  const std::vector<std::string>& chain = rig.system->joint_names();
  const int beyond = joint - static_cast<int>(chain.size());
  const ExternalRig* external = beyond >= 0 ? external_rig(*rig.system) : nullptr;
  return external ? name_at(external->hanging_names(), beyond) : name_at(chain, joint);
}

void set_place(const Metric& metric, int place, const std::vector<std::string>& joint_names,
               Finding& finding) {
  switch (metric.place) {
    case PlaceKind::joint:
      finding.joint = name_at(joint_names, place);
      break;
    case PlaceKind::slice:
      finding.slice = place;
      break;
    case PlaceKind::vertex:
      finding.vertex = place;
      break;
    case PlaceKind::none:
      break;
  }
}

bool is_applicable(const RigRecord& rig, const Metric& metric, const PoseRecord& pose) {
  return is_applicable(metric, {rig.system->rest(), rig.surface, rig.has_arms}, pose);
}

std::optional<Finding> share_finding(const RigRecord& rig, const JudgeContext& context,
                                     const SweepRecord& sweep,
                                     std::span<const ShareExcess> shares) {
  const auto over = [](const ShareExcess& each) { return each.deg - each.limit_deg; };
  std::size_t worst = 0;
  for (std::size_t i = 1; i < shares.size(); ++i)
    if (over(shares[i]) > over(shares[worst]) + 1e-3) worst = i;
  if (shares.empty() || !(over(shares[worst]) > 0.0)) return std::nullopt;
  const auto poses =
      std::ranges::count_if(shares, [&](const ShareExcess& each) { return over(each) > 0.0; });
  const ShareExcess& excess = shares[worst];
  const auto joint = static_cast<std::size_t>(excess.joint) + 1;  // the hips have no share
  const PoseRecord& pose = sweep.poses[worst];
  Finding finding = rig.recording
                        ? start_finding(rig, context, sweep, "BB010", worst)
                        : start_finding(rig, context, sweep, "BB010", pose.body, pose.control_deg);
  finding.value = excess.deg;
  finding.limit = excess.limit_deg;
  finding.joint =
      rig.recording ? rig.recording->watched[joint].name : joint_name(rig, static_cast<int>(joint));
  finding.detail = finding.joint + words_of(excess, bone_at_rest(rig, context, joint)) + ", in " +
                   std::to_string(poses) + " of " + std::to_string(shares.size()) +
                   (rig.recording ? " frames" : " poses");
  if (rig.recording) finding.geometry["frames"] = static_cast<double>(poses);
  return finding;
}

std::vector<Finding> judge_rig(const RigRecord& rig, const JudgeContext& context) {
  std::vector<Finding> findings;
  for (const SweepRecord& sweep : rig.sweeps) {
    const std::size_t first = findings.size();
    const auto is_told = [&](std::string_view code) {
      return std::any_of(findings.begin() + static_cast<std::ptrdiff_t>(first), findings.end(),
                         [&](const Finding& each) { return each.code == code; });
    };
    if (rig.recording)
      judge_recorded(rig, context, sweep, findings);
    else
      for (const Jump& jump : sweep.flips.jumps)
        findings.push_back(flip_finding(rig, context, sweep, jump));
    for (const Metric& metric : metric_table()) {
      const Check& check = metric.check();
      if (!check.decides || is_told(check.code)) continue;
      const bool on_mesh =
          !rig.recording && check.subject == Subject::mesh && metric.id != MetricId::feasibility;
      auto worst = worst_failing(rig, sweep, metric, context, true, on_mesh);
      if (!worst) worst = worst_failing(rig, sweep, metric, context, true, false);
      if (!worst) worst = worst_failing(rig, sweep, metric, context, false, on_mesh);
      if (!worst) worst = worst_failing(rig, sweep, metric, context, false, false);
      if (worst) findings.push_back(metric_finding(rig, context, sweep, metric, *worst));
    }
  }
  std::stable_sort(findings.begin(), findings.end(), [&](const Finding& a, const Finding& b) {
    if ((a.verdict == Verdict::fail) != (b.verdict == Verdict::fail))
      return a.verdict == Verdict::fail;
    return excess(*find_check(a.code), a.value, a.limit) >
           excess(*find_check(b.code), b.value, b.limit);
  });
  return findings;
}

namespace {

/// The deciding check that a pose misses by most, and by how much; nothing where it is clean.
struct Miss {
  std::string_view code;
  double excess = 0.0;
};

/// Checks by sweep that are over their limit inside the envelope because of the skeleton or the
/// pose.
using Advisories = std::set<std::pair<const SweepRecord*, std::string>>;

Advisories advisories_in(const RigRecord& rig, const std::vector<Finding>& findings) {
  Advisories out;
  for (const Finding& finding : findings)
    if (finding.inside_envelope && finding.verdict != Verdict::fail &&
        (finding.owner == Owner::skeleton || finding.owner == Owner::pose))
      out.emplace(sweep_of(rig, finding), finding.code);
  return out;
}

std::optional<Miss> worst_miss(const RigRecord& rig, const JudgeContext& context,
                               const Advisories& advisories, const SweepRecord& sweep,
                               const PoseRecord& pose) {
  std::optional<Miss> worst;
  const double load = compound_load(context.envelope, pose.body);
  for (const Metric& metric : metric_table()) {
    const Check& check = metric.check();
    if (!check.decides || !is_applicable(rig, metric, pose)) continue;
    const double value = pose.at(metric.id).value;
    const double limit = limit_at(check.code, context.limits.of(check.code).value, load);
    if (judge(check, value, limit) != Verdict::fail) continue;
    if (pose.inside && advisories.contains({&sweep, std::string(check.code)})) continue;
    // Nor does a pose that the body is too thick for count, where a milder pose has decided.
    if (pose.inside && check.subject == Subject::mesh && is_infeasible(check, pose)) continue;
    const double here = excess(check, value, limit);
    if (!worst || here > worst->excess) worst = Miss{check.code, here};
  }
  return worst;
}

}  // namespace

std::vector<Headroom> headroom_of(const RigRecord& rig, const JudgeContext& context,
                                  const std::vector<Finding>& findings) {
  const Advisories advisories = advisories_in(rig, findings);
  std::vector<Headroom> result;
  for (const std::string_view channel : kBendChannels) {
    Headroom headroom;
    headroom.channel = channel;
    headroom.needs_deg = context.envelope.needs(channel);
    double dirty_from = std::numeric_limits<double>::infinity();
    std::vector<double> tested;
    double least = 0.0, most = 0.0;
    for (const SweepRecord& sweep : rig.sweeps) {
      if (!moves_alone(sweep.sweep, channel)) continue;
      if (!std::ranges::all_of(sweep.poses, &PoseRecord::taken)) continue;
      const double span = sweep.sweep.to_deg - sweep.sweep.from_deg;
      for (const Jump& jump : sweep.flips.jumps) {
        dirty_from = std::min(dirty_from, std::abs(sweep.sweep.from_deg + span * jump.t));
      }
      for (const PoseRecord& pose : sweep.poses) {
        headroom.measured = true;
        tested.push_back(std::abs(pose.control_deg));
        least = std::min(least, pose.control_deg);
        most = std::max(most, pose.control_deg);
        if (worst_miss(rig, context, advisories, sweep, pose))
          dirty_from = std::min(dirty_from, std::abs(pose.control_deg));
      }
    }
    for (const double angle : tested)
      if (angle < dirty_from) headroom.clean_to_deg = std::max(headroom.clean_to_deg, angle);
    // Side and twist are needed both ways; everything that was swept counts as it was swept.
    const bool both_ways = channel == "side" || channel == "twist";
    headroom.tested_to_deg = both_ways && !context.envelope.whole_sweep ? std::min(-least, most)
                                                                        : std::max(-least, most);
    headroom.clean_to_deg = std::min(headroom.clean_to_deg, headroom.tested_to_deg);
    if (context.envelope.whole_sweep) headroom.needs_deg = headroom.tested_to_deg;
    if (headroom.measured || headroom.needs_deg > 0.0) result.push_back(headroom);
  }
  return result;
}

Corners corners_of(const RigRecord& rig, const JudgeContext& context,
                   const std::vector<Finding>& findings) {
  const Advisories advisories = advisories_in(rig, findings);
  Corners corners;
  corners.needed = !corner_sweeps(context.envelope).empty();
  double worst = 0.0;
  for (const SweepRecord& sweep : rig.sweeps) {
    if (!sweep.sweep.corner) continue;
    for (const PoseRecord& pose : sweep.poses) {
      if (!pose.inside) continue;
      ++corners.poses;
      const auto miss = worst_miss(rig, context, advisories, sweep, pose);
      if (!miss) {
        ++corners.clean;
      } else if (miss->excess > worst) {
        worst = miss->excess;
        corners.worst = pose.body.text();
        corners.code = miss->code;
      }
    }
  }
  return corners;
}

int clean_poses(const RigRecord& rig, const SweepRecord& sweep, const JudgeContext& context,
                const std::vector<Finding>& findings) {
  const Advisories advisories = advisories_in(rig, findings);
  return static_cast<int>(std::ranges::count_if(sweep.poses, [&](const PoseRecord& pose) {
    return !worst_miss(rig, context, advisories, sweep, pose);
  }));
}

std::vector<Coverage> coverage_of(const RigRecord& rig) {
  std::vector<Coverage> result;
  Coverage flips{"BB001", 0, 0, 0, 0};
  for (const SweepRecord& sweep : rig.sweeps) {
    ++flips.planned;
    // A rig that cannot take a sweep did not move in it.
    const bool taken = sweep.searched && std::ranges::all_of(sweep.poses, &PoseRecord::taken);
    ++(!taken ? flips.not_applicable : sweep.flips.certified ? flips.measured : flips.not_measured);
  }
  flips.planned += rig.search.paths;
  flips.measured += rig.search.paths - rig.search.unsure;
  flips.not_measured += rig.search.unsure;
  result.push_back(flips);
  if (rig.recording) {
    Coverage responses{"BB049", 0, 0, 0, 0};
    for (const SweepRecord& sweep : rig.sweeps) {
      ++responses.planned;
      ++(sweep.response ? responses.measured : responses.not_applicable);
    }
    result.push_back(responses);
  }
  for (const Metric& metric : metric_table()) {
    const Check& check = metric.check();
    if (check.subject == Subject::mesh && !rig.has_mesh) continue;
    Coverage coverage{std::string(check.code), 0, 0, 0, 0};
    for (const SweepRecord& sweep : rig.sweeps) {
      for (const PoseRecord& pose : sweep.poses) {
        // Once for a rig.
        if (metric.id == MetricId::return_to_rest && !pose.rest_noted && !rig.recording) continue;
        ++coverage.planned;
        if (!is_applicable(rig, metric, pose)) {
          ++coverage.not_applicable;
        } else if (std::isfinite(pose.at(metric.id).value)) {
          ++coverage.measured;
        } else {
          ++coverage.not_measured;
        }
      }
    }
    result.push_back(coverage);
  }
  std::sort(result.begin(), result.end(),
            [](const Coverage& a, const Coverage& b) { return a.code < b.code; });
  return result;
}

std::vector<SweepSeries> series_of(const RigRecord& rig, const LimitSet& limits) {
  std::vector<SweepSeries> result;
  for (const SweepRecord& sweep : rig.sweeps) {
    SweepSeries series;
    series.sweep = sweep.sweep.name;
    series.channel = sweep.sweep.channel.empty() ? "frame" : sweep.sweep.channel;
    series.mapping = rig.mapping_text();
    for (const std::string_view channel : kChannels) {
      if (rig.recording) break;  // its poses are not in channels
      std::vector<double> degrees;
      for (const PoseRecord& pose : sweep.poses) degrees.push_back(*pose.body.find(channel));
      const bool bend = std::ranges::find(kBendChannels, channel) != kBendChannels.end();
      if (!bend && std::ranges::all_of(degrees, [](double v) { return v == 0.0; })) continue;
      series.pose_deg[std::string(channel)] = std::move(degrees);
    }
    for (const PoseRecord& pose : sweep.poses) series.control_deg.push_back(pose.control_deg);
    for (const Metric& metric : metric_table()) {
      const std::string name(metric.name);
      std::vector<double>& values = series.metric[name];
      for (const PoseRecord& pose : sweep.poses)
        values.push_back(rig.recording || is_applicable(rig, metric, pose)
                             ? pose.at(metric.id).value
                             : std::numeric_limits<double>::quiet_NaN());
      if (std::none_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); })) {
        series.metric.erase(name);
        continue;
      }
      series.metric_unit[name] = metric.check().unit;
      series.metric_limit[name] = limits.of(metric.code).value;
    }
    result.push_back(std::move(series));
  }
  return result;
}

RigResult result_of(const RigRecord& rig, const JudgeContext& context,
                    const std::vector<Finding>& findings) {
  RigResult result;
  result.character = context.stage.character().name;
  result.rig = rig.plan.name;
  result.system = rig.plan.spec.system;
  result.mapping = rig.mapping_text();
  result.role = rig.plan.role;
  for (const auto& [key, value] : rig.system->options()) {
    result.options[key] = rig_text({"", {{key, value}}}).substr(key.size() + 2);
  }
  result.headroom = headroom_of(rig, context, findings);
  result.corners = corners_of(rig, context, findings);
  result.search = rig.search;
  result.hunt = rig.hunt;
  result.volume = rig.volume;
  result.coverage = coverage_of(rig);
  result.sweeps = series_of(rig, context.limits);
  for (const SweepSeries& series : result.sweeps) {
    for (const auto& [name, values] : series.metric) {
      const Metric* metric = metric_named(name);
      const bool low_is_bad = metric != nullptr && metric->check().sense == Sense::at_least;
      for (const double value : values) {
        if (!std::isfinite(value)) continue;
        const auto [worst, is_new] = result.summary.emplace(name, value);
        if (!is_new)
          worst->second =
              low_is_bad ? std::min(worst->second, value) : std::max(worst->second, value);
      }
    }
  }
  return result;
}

}  // namespace backbend::validate
