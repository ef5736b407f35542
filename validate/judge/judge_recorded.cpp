#include "validate/judge/judge_recorded.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "validate/metrics/chain/clip_flip.h"

namespace backbend::validate {
namespace {

using Against = WatchedJoint::Against;

/// The joint that stands for all of a jump: the widest of a single joint, the lowest on the chain
/// where several are as wide; or, where many small ones add up, what they come to, at the lowest
/// joint that turns by all of it.
const JointJump& leading_joint(const Recording& recording, const Jump& jump) {
  constexpr double kAsWide = 0.9, kAddsUp = 1.15;
  const auto lowest_widest = [&](bool of_sums) {
    const auto is_counted = [&](const JointJump& each) {
      return (recording.watched[each.joint].against == Against::hips) == of_sums;
    };
    const JointJump* best = nullptr;
    double widest = 0.0;
    for (const JointJump& each : jump.joints)
      if (is_counted(each)) widest = std::max(widest, each.size_deg);
    for (const JointJump& each : jump.joints)
      if (best == nullptr && is_counted(each) && each.size_deg >= kAsWide * widest) best = &each;
    return best;
  };
  const JointJump *own = lowest_widest(false), *sum = lowest_widest(true);
  if (own == nullptr) return *sum;
  return sum != nullptr && sum->size_deg > kAddsUp * own->size_deg ? *sum : *own;
}

Finding recorded_flip_finding(const RigRecord& rig, const JudgeContext& context,
                              const SweepRecord& sweep, const Jump& jump) {
  const Recording& recording = *rig.recording;
  std::string joints;
  for (const JointJump& each : jump.joints) {
    const WatchedJoint& joint = recording.watched[each.joint];
    if (joint.against != Against::hips)
      joints += (joints.empty() ? "" : ", ") + joint.name + " by " + number_text(each.size_deg, 1) +
                " deg";
  }
  const JointJump& leading = leading_joint(recording, jump);
  const WatchedJoint& joint = recording.watched[leading.joint];
  Finding finding = start_finding(rig, context, sweep, "BB001", jump.pose + 1);
  finding.value = leading.size_deg;
  finding.limit = leading.expected_deg;
  finding.joint = joint.name;
  finding.detail = leading.frames_out == 0   ? "jump from one frame to the next, and it stays: "
                   : leading.frames_out == 1 ? "pop for one frame, out and back: "
                                             : "pop, out and back after " +
                                                   std::to_string(leading.frames_out) + " frames: ";
  if (joint.against == Against::hips)
    finding.detail += joint.name + " by " + number_text(leading.size_deg, 1) +
                      " deg against the hips, what the joints below it add up to" +
                      (joints.empty() ? "" : " (" + joints + ")");
  else
    finding.detail += joints;
  if (joint.against == Against::world) finding.detail += ", in the world";
  finding.detail += "; the motion around explains " + number_text(leading.expected_deg, 1) + " deg";
  finding.geometry["before_deg"] = sweep.poses[jump.pose].control_deg;
  finding.geometry["after_deg"] = finding.control_deg;
  finding.geometry["frames_out"] = static_cast<double>(leading.frames_out);
  finding.geometry["joints"] = static_cast<double>(jump.joints.size());
  return finding;
}

/// A channel whose control does not turn the chest as the channel's name says: the mapping names
/// another control, another axis or the other sign, or the rig does not carry the turn to the
/// chest.
std::optional<Finding> response_finding(const RigRecord& rig, const JudgeContext& context,
                                        const SweepRecord& sweep) {
  if (!sweep.response) return std::nullopt;
  const ChannelResponse& response = *sweep.response;
  Finding finding = start_finding(rig, context, sweep, "BB049", response.pose);
  if (judge(*find_check(finding.code), response.share(), finding.limit) != Verdict::fail)
    return std::nullopt;
  finding.owner = Owner::input;
  finding.joint = rig.recording->watched[context.stage.anatomy().chest_index].name;
  const double asked = std::abs(response.asked_deg), least = finding.limit * asked;
  finding.detail = "of " + number_text(asked, 1) + " deg of " + response.channel + ", " +
                   number_text(response.arrived_deg * response.asked_deg / asked, 1) +
                   " arrive at the chest";
  finding.detail += response.arrived_deg * response.asked_deg < -least * asked
                        ? ": it turns the other way round"
                    : response.other_deg > least
                        ? ", and " + number_text(response.other_deg, 1) + " deg about other axes"
                        : "";
  finding.detail += "; see which control and which sign the mapping gives this channel";
  set_response(response, finding);
  return finding;
}

}  // namespace

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

std::string frame_text(const SweepRecord& sweep, std::size_t index) {
  const PoseRecord& pose = sweep.poses[index];
  const std::string& channel = sweep.sweep.channel;
  const std::string text =
      channel.empty() ? "" : channel + " " + number_text(pose.control_deg, 3) + ", ";
  if (!pose.frame) return text + "pose " + std::to_string(index);
  return text + "frame " + std::to_string(*pose.frame) + " (" + number_text(pose.time_s, 3) + " s)";
}

void judge_recorded(const RigRecord& rig, const JudgeContext& context, const SweepRecord& sweep,
                    std::vector<Finding>& findings) {
  for (const Jump& jump : sweep.flips.jumps)
    findings.push_back(recorded_flip_finding(rig, context, sweep, jump));
  if (!sweep.flips.finite) {
    Finding finding = start_finding(rig, context, sweep, "BB050", sweep.flips.not_finite_pose);
    finding.value = 1.0;
    finding.detail = "a joint's matrix has no rotation: mirrored, collapsed or not finite";
    findings.push_back(std::move(finding));
  }
  if (auto response = response_finding(rig, context, sweep)) findings.push_back(*response);
  if (auto share = share_finding(rig, context, sweep, sweep.shares)) findings.push_back(*share);
}

void describe_recorded(const RigRecord& rig, const JudgeContext& context, const SweepRecord& sweep,
                       const Metric& metric, Finding& finding) {
  const auto index = static_cast<std::size_t>(finding.at.pose);
  const int place = sweep.poses[index].at(metric.id).place;
  const bool slides = metric.id == MetricId::arm_shift, drifts = metric.id == MetricId::arm_drift;
  if ((slides || drifts) && place >= 0)
    finding.joint = rig.recording->watched[static_cast<std::size_t>(place)].name;
  const auto frames = std::ranges::count_if(sweep.poses, [&](const PoseRecord& pose) {
    return judge(metric.check(), pose.at(metric.id).value, finding.limit) == Verdict::fail;
  });
  const std::string how_many = "beyond the limit in " + std::to_string(frames) + " of " +
                               std::to_string(sweep.poses.size()) + " frames";
  if (slides)
    finding.detail = finding.joint + " slides on its parent by " + number_text(finding.value, 2) +
                     " % of the spine (" +
                     number_text(10.0 * finding.value * context.stage.anatomy().spine_length, 1) +
                     " mm); ";
  if (drifts)
    finding.detail = finding.joint + " turns by " + number_text(finding.value, 2) +
                     " deg against what carries it, with no arm control moved; ";
  finding.detail += how_many;
  // It may be intended, and a clip has no option for it: shown, never deciding.
  if (metric.id == MetricId::length_change) {
    finding.verdict = Verdict::stress;
    finding.detail += "; no option says how much stretch is meant";
  }
}

}  // namespace backbend::validate
