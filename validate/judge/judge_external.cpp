#include "validate/judge/judge_external.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "skin/anatomy/mirror_image.h"
#include "validate/live/external_rig.h"
#include "validate/measure/compound_search.h"
#include "validate/metrics/chain/bend_shares.h"
#include "validate/metrics/chain/chain.h"

namespace backbend::validate {
namespace {

using Index = std::size_t;

// The stretch of a channel that one reading takes, and the turn below which nothing arrives.
constexpr double kReadOver_deg = 30.0, kNothing_deg = 0.5;

PoseDegrees pose_of(std::string_view channel, double angle) {
  PoseDegrees pose;
  *pose.find(channel) = angle;
  return pose;
}

/// What a mapping that answers so near rest has wrong, as the one who wrote it would say it.
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
           " deg about other axes: the mapping's axis is wrong, or the rig couples them";
  if (turned > response.asked_deg)
    return "the chest turns too far, by " + number_text(turned, 1) +
           " deg in all: per_degree is too large";
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

/// Unit, of the body at rest: what a channel's positive angles turn about.
glm::dvec3 axis_of(const solver::SpineSystem& system, std::string_view channel,
                   const glm::dvec3& left) {
  const std::vector<glm::dvec3>& joint = system.rest().position;
  const glm::dvec3 chest = joint.back() - joint.front();
  const glm::dvec3 along = glm::normalize(chest - left * glm::dot(chest, left));
  return channel == "extension" ? -left
         : channel == "flexion" ? left
         : channel == "twist"   ? along
                                : -glm::cross(left, along);
}

/// A channel's answer from pose to pose of its sweep, away from rest.
struct Answers {
  std::vector<double> angle_deg;  // signed, rising in size; starts at rest
  std::vector<glm::dvec3> turn;   // degrees, from rest to there

  ChannelResponse between(Index from, Index to, std::string_view channel,
                          const glm::dvec3& axis) const {
    const glm::dvec3 turned = turn[to] - turn[from];
    ChannelResponse out{std::string(channel), angle_deg[to] - angle_deg[from],
                        glm::dot(turned, axis), 0.0};
    out.other_deg = glm::length(turned - axis * out.arrived_deg);
    out.from_deg = angle_deg[from];
    return out;
  }
};

/// `sign`: of the angles.
Answers answers_of(const RigRecord& rig, const SweepRecord& sweep, double sign) {
  Answers out{{0.0}, {glm::dvec3(0.0)}};
  std::vector<const PoseRecord*> poses;
  for (const PoseRecord& pose : sweep.poses)
    if (pose.control_deg * sign > 0.0) poses.push_back(&pose);
  std::ranges::sort(poses, {}, [](const PoseRecord* pose) { return std::abs(pose->control_deg); });
  solver::SpinePose before = rig.system->rest(), now;
  for (const PoseRecord* pose : poses) {
    rig.system->solve_into(pose->control, solver::Detail::joints, now);
    out.turn.push_back(out.turn.back() + 180.0 / kPi * sum_of_turns(before, now));
    out.angle_deg.push_back(pose->control_deg);
    std::swap(before, now);
  }
  return out;
}

/// Whether the rig jumps between two angles of a sweep: what arrives there is another finding.
bool jumps_between(const SweepRecord& sweep, double a, double b) {
  const double span = sweep.sweep.to_deg - sweep.sweep.from_deg;
  return std::ranges::any_of(sweep.flips.jumps, [&](const Jump& jump) {
    const double at = sweep.sweep.from_deg + span * jump.t;
    return at >= std::min(a, b) && at <= std::max(a, b);
  });
}

/// The stretch of a sweep, away from rest, that the chest does not follow, with the pose that ends
/// it: from where it stays behind to where it follows again, or to the sweep's end. Nullopt: it
/// follows each 30 degrees of the channel by more than the limit.
std::optional<ChannelResponse> stretch_unanswered(const RigRecord& rig, const SweepRecord& sweep,
                                                  const glm::dvec3& left, double limit) {
  const std::string& channel = sweep.sweep.channel;
  const glm::dvec3 axis = axis_of(*rig.system, channel, left);
  const auto misses = [&](const ChannelResponse& response) {
    return judge(*find_check("BB049"), response.share(), limit) == Verdict::fail;
  };
  std::optional<ChannelResponse> nearest;
  for (const double sign : {1.0, -1.0}) {
    const Answers answers = answers_of(rig, sweep, sign);
    // What has arrived beyond the share that should have: it falls where the chest stays behind.
    const auto ahead = [&](Index i) {
      return sign * glm::dot(answers.turn[i], axis) - limit * std::abs(answers.angle_deg[i]);
    };
    for (Index to = 1, from = 0; to < answers.angle_deg.size(); ++to) {
      const auto width = [&](Index i) {
        return std::abs(answers.angle_deg[to] - answers.angle_deg[i]);
      };
      while (width(from + 1) >= kReadOver_deg) ++from;
      if (width(from) < kReadOver_deg || from == 0) continue;  // from rest: asked by itself
      if (jumps_between(sweep, answers.angle_deg[from], answers.angle_deg[to])) continue;
      ChannelResponse response = answers.between(from, to, channel, axis);
      if (!misses(response)) continue;
      if (ahead(to) < ahead(from)) {
        Index start = from, end = to;
        for (Index i = from; i < to; ++i)
          if (ahead(i) > ahead(start)) start = i;
        for (Index i = to; i < answers.angle_deg.size(); ++i)
          if (ahead(i) < ahead(end)) end = i;
        response = answers.between(start, end, channel, axis);
      }
      if (!nearest || std::abs(response.from_deg) < std::abs(nearest->from_deg)) nearest = response;
      break;
    }
  }
  return nearest;
}

Finding response_finding(const RigRecord& rig, const JudgeContext& context,
                         const SweepRecord& sweep, const ExternalRig& external,
                         const ChannelResponse& response) {
  const double read_deg = response.from_deg + response.asked_deg;
  Finding finding =
      start_finding(rig, context, sweep, "BB049", pose_of(response.channel, read_deg), read_deg);
  const bool from_rest = response.from_deg == 0.0;
  // Whatever the envelope: all that is said of this channel rests on it.
  if (from_rest)
    finding.verdict = Verdict::fail;
  else
    finding.owner = Owner::rig;  // near rest the mapping is right
  finding.detail =
      "of " + number_text(std::abs(response.asked_deg), 1) + " deg of " + response.channel + " (" +
      targets_text(external, response.channel) + ")" +
      (from_rest
           ? ""
           : " from " + number_text(response.from_deg, 1) + " to " + number_text(read_deg, 1)) +
      ", " + number_text(std::copysign(1.0, response.asked_deg) * response.arrived_deg, 1) +
      " arrive at the chest: ";
  if (from_rest)
    finding.detail += cause_of(response);
  else if (response.share() * std::abs(response.asked_deg) < -kNothing_deg)
    finding.detail += "it turns back";
  else if (std::hypot(response.arrived_deg, response.other_deg) > std::abs(response.asked_deg))
    finding.detail += "it turns " +
                      number_text(std::hypot(response.arrived_deg, response.other_deg), 1) +
                      " deg in all, " + number_text(response.other_deg, 1) + " about other axes";
  else
    finding.detail += "a control or a joint has come to its limit, or is driven no farther";
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
  const auto pose_at = [&](double angle) {
    return system.solve(controls_at(system, pose_of(channel, angle), mapping));
  };
  const glm::dvec3 axis = axis_of(system, channel, left);
  const glm::dvec3 turn = sum_of_turns(pose_at(0.0), pose_at(kReadOver_deg));
  ChannelResponse out{std::string(channel), kReadOver_deg, degrees(glm::dot(turn, axis)), 0.0};
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
    const double limit = context.limits.of("BB049").value;
    if (judge(*find_check("BB049"), response.share(), limit) == Verdict::fail) {
      out.findings.push_back(response_finding(rig, context, *sweep, *external, response));
      out.answered_to.push_back({std::string(channel), 0.0});
      continue;
    }
    // Of several sweeps of one channel, the stretch that begins nearest to rest.
    std::optional<ChannelResponse> nearest;
    const SweepRecord* of_nearest = nullptr;
    for (const SweepRecord& each : rig.sweeps) {
      if (!moves_alone(each.sweep, channel)) continue;
      const auto stretch = stretch_unanswered(rig, each, context.stage.anatomy().left, limit);
      if (!stretch || (nearest && std::abs(stretch->from_deg) >= std::abs(nearest->from_deg)))
        continue;
      nearest = stretch;
      of_nearest = &each;
    }
    if (!nearest) continue;
    out.findings.push_back(response_finding(rig, context, *of_nearest, *external, *nearest));
    out.answered_to.push_back({std::string(channel), std::abs(nearest->from_deg)});
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
