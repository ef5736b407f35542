#include "validate/judge/judge_external.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "skin/anatomy/mirror_image.h"
#include "validate/live/external_rig.h"
#include "validate/measure/compound_search.h"
#include "validate/metrics/chain/bend_shares.h"
#include "validate/metrics/chain/chain.h"

namespace backbend::validate {
namespace {

using Index = std::size_t;

// Where a channel is read, and what of it counts as nothing, degrees.
constexpr double kReadAt_deg = 30.0, kNothing_deg = 0.5;

PoseDegrees pose_of(std::string_view channel, double angle) {
  PoseDegrees pose;
  *pose.find(channel) = angle;
  return pose;
}

/// What a mapping that answers so has wrong, as the one who wrote it would say it.
std::string cause_of(const ChannelResponse& response) {
  const double turned = std::hypot(response.arrived_deg, response.other_deg);
  if (turned < kNothing_deg)
    return response.channel == "twist" ? "nothing of it arrives: the chain does not carry this "
                                         "twist, or the control is not "
                                         "the chest's"
                                       : "nothing of it arrives: the control that the mapping "
                                         "names does not move the spine";
  if (-response.arrived_deg > response.other_deg)
    return "the chest turns the other way round: the mapping's sign is wrong";
  if (response.other_deg > std::abs(response.arrived_deg))
    return "the chest turns " + number_text(response.other_deg, 1) +
           " deg about other axes: the mapping's axis is wrong";
  return "the rest is lost on the way, or per_degree is too small";
}

std::string targets_text(const ExternalRig& rig, std::string_view channel) {
  std::string text;
  for (const ControlTarget& target : rig.mapping().targets(channel))
    text += (text.empty() ? "" : ", ") + target.channel + " x " + number_text(target.per_degree);
  return text;
}

const SweepRecord* sweep_of(const RigRecord& rig, std::string_view channel) {
  for (const SweepRecord& sweep : rig.sweeps)
    if (moves_alone(sweep.sweep, channel)) return &sweep;
  return nullptr;
}

Finding response_finding(const RigRecord& rig, const JudgeContext& context,
                         const SweepRecord& sweep, const ExternalRig& external,
                         const ChannelResponse& response) {
  Finding finding = start_finding(rig, context, sweep, "BB049",
                                  pose_of(response.channel, kReadAt_deg), kReadAt_deg);
  // Whatever the envelope: all that is said of this channel rests on it.
  finding.verdict = Verdict::fail;
  finding.detail = "of " + number_text(response.asked_deg, 1) + " deg of " + response.channel +
                   " (" + targets_text(external, response.channel) + "), " +
                   number_text(response.arrived_deg, 1) +
                   " arrive at the chest: " + cause_of(response);
  set_response(response, finding);
  finding.image.note = "no picture metric looks at this";
  return finding;
}

void judge_memory(const RigRecord& rig, const JudgeContext& context, const ExternalRig& external,
                  ExternalJudgement& out) {
  out.coverage.push_back({"BB044", 1, 1, 0, 0});
  const ExternalRig::Memory& memory = external.memory();
  if (!external.has_memory() || rig.sweeps.empty()) return;
  PoseDegrees pose;
  pose.extension = degrees(memory.pose.extension);
  pose.flexion = degrees(memory.pose.flexion);
  pose.side = degrees(memory.pose.side);
  pose.twist = degrees(memory.pose.twist);
  Finding finding = start_finding(rig, context, rig.sweeps.front(), "BB044", pose, 0.0);
  finding.verdict = Verdict::fail;
  finding.value = 100.0 * memory.share;
  finding.joint = joint_name(rig, memory.joint);
  finding.detail =
      "the same pose, asked for again in another order, is another: " +
      (memory.point >= 0 ? "point " + std::to_string(memory.point) + " of its mesh differs by "
                         : "'" + finding.joint + "' differs by " + number_text(memory.turn_deg, 2) +
                               " deg and ") +
      number_text(100.0 * memory.shift, 2) +
      " % of spine; the rig has a memory: jumps were not looked for, and no figure "
      "of it holds";
  finding.image.note = "no picture metric looks at this";
  out.findings.push_back(std::move(finding));
}

/// What each pose of a sweep has beyond its share of the bend.
std::vector<ShareExcess> shares_of(const RigRecord& rig, const JudgeContext& context,
                                   const SweepRecord& sweep) {
  const Index joints = rig.system->rest().turn.size() - 1;
  std::vector<glm::dvec3> turn;
  for (const PoseRecord& record : sweep.poses) {
    const solver::SpinePose pose = rig.system->solve(record.control);
    for (Index k = 1; k <= joints; ++k)
      turn.push_back(rotation_vector(glm::conjugate(pose.turn[k - 1]) * pose.turn[k]));
  }
  const skin::Anatomy& anatomy = context.stage.anatomy();
  const skin::Character& body = context.stage.character();
  const skin::Mirror mirror = skin::mirror_of(body, anatomy);
  return joint_excess(
      turn, joints, skin::body_axes(anatomy, mirror),
      {true, skin::spine_is_in_the_middle(body, anatomy, mirror), rig.system->rest().position});
}

}  // namespace

LimitSet external_limits(LimitSet limits) {
  limits.set("BB010", {25.0, LimitLayer::builtin, "rigs of your own", "backbend",
                       "no curve is known that the chain should follow: a joint is held against "
                       "its neighbours, as in baked clips"});
  limits.set("BB014", {25.0, LimitLayer::builtin, "rigs of your own", "backbend",
                       "no twist is known that the chain should carry, and rigs share it as they "
                       "like; a joint that leaves its share of a sweep is in BB010"});
  return limits;
}

std::string resolution_note(const RigRecord& rig) {
  if (!external_rig(*rig.system)) return {};
  Index evaluations = 0, sweeps = 0;
  double smallest_deg = 0.0;
  std::map<std::string, double> width_deg;  // the widest of a channel's sweeps
  for (const SweepRecord& sweep : rig.sweeps) {
    const FlipReport& flips = sweep.flips;
    if (!flips.certified || flips.samples == 0) continue;
    ++sweeps;
    evaluations += flips.samples;
    smallest_deg = std::max(smallest_deg, flips.smallest_deg);
    for (const std::string_view channel : kBendChannels) {
      if (!moves_alone(sweep.sweep, channel)) continue;
      double& width = width_deg[std::string(channel)];
      width =
          std::max(width, flips.smallest_gap * std::abs(sweep.sweep.to_deg - sweep.sweep.from_deg));
    }
  }
  if (width_deg.empty()) return {};
  std::string text = "rig " + rig.plan.name + ": " + std::to_string(evaluations) +
                     " evaluations along " + std::to_string(sweeps) +
                     " sweeps looked for jumps of " + number_text(smallest_deg) +
                     " deg and more; not seen is what goes and comes back within less than";
  for (const auto& [channel, width] : width_deg)
    text += " " + number_text(width, 3) + " deg of " + channel + ",";
  text.back() = ';';
  text += " sweeps with a smaller step look closer";
  if (rig.search.paths > 0)
    text += "; between the sweeps jumps of " + number_text(kSmallestAsked_deg) +
            " deg and more were looked for";
  return text;
}

ChannelResponse channel_response(const solver::SpineSystem& system, solver::Mapping mapping,
                                 std::string_view channel, const glm::dvec3& left) {
  ChannelResponse out{std::string(channel), kReadAt_deg, 0.0, 0.0};
  const auto turn_at = [&](double angle) {
    return sum_of_turns(system.solve(controls_at(system, pose_of(channel, angle), mapping)));
  };
  const std::vector<glm::dvec3>& joint = system.rest().position;
  const glm::dvec3 chest = joint.back() - joint.front();
  const glm::dvec3 along = glm::normalize(chest - left * glm::dot(chest, left));
  const glm::dvec3 axis = channel == "extension" ? -left
                          : channel == "flexion" ? left
                          : channel == "twist"   ? along
                                                 : -glm::cross(left, along);
  const glm::dvec3 turn = turn_at(kReadAt_deg) - turn_at(0.0);
  out.arrived_deg = degrees(glm::dot(turn, axis));
  out.other_deg = degrees(glm::length(turn - axis * glm::dot(turn, axis)));
  return out;
}

ExternalJudgement judge_external(const RigRecord& rig, const JudgeContext& context) {
  ExternalJudgement out;
  const ExternalRig* external = external_rig(*rig.system);
  if (!external) return out;
  Coverage responses{"BB049", 0, 0, 0, 0};
  for (const std::string_view channel : kBendChannels) {
    const SweepRecord* sweep = sweep_of(rig, channel);
    if (!sweep) continue;
    ++responses.planned;
    if (!external->maps(channel)) {
      ++responses.not_measured;
      continue;
    }
    const ChannelResponse response =
        channel_response(*rig.system, rig.mapping, channel, context.stage.anatomy().left);
    if (!std::isfinite(response.share())) {
      ++responses.not_measured;
      continue;
    }
    ++responses.measured;
    const Check& check = *find_check("BB049");
    if (judge(check, response.share(), context.limits.of("BB049").value) != Verdict::fail) continue;
    out.findings.push_back(response_finding(rig, context, *sweep, *external, response));
    out.unanswered.emplace_back(channel);
  }
  out.coverage.push_back(responses);
  for (const SweepRecord& sweep : rig.sweeps) {
    // A jump in the sweep tells of it.
    if (!sweep.flips.jumps.empty() || !std::ranges::all_of(sweep.poses, &PoseRecord::taken))
      continue;
    if (auto finding = share_finding(rig, context, sweep, shares_of(rig, context, sweep)))
      out.findings.push_back(*finding);
  }
  judge_memory(rig, context, *external, out);
  return out;
}

}  // namespace backbend::validate
