#include "validate/night/pose_hunt.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>

#include "validate/files/output_folder.h"
#include "validate/hunt/hunt.h"
#include "validate/judge/owner.h"
#include "validate/measure/measure_job.h"
#include "validate/measure/records.h"
#include "validate/metrics/math/least_share.h"
#include "validate/prove/proof.h"
#include "validate/sweeps/external_spec.h"
#include "validate/sweeps/named_pose.h"
#include "validate/verdicts/checks.h"

namespace backbend::validate {
namespace {

using nlohmann::json;

constexpr double kSampled = 1.0 / 3.0;  // of the evaluations
// What a sweep shows is only measured again where a pose goes further over the limit than that.
constexpr double kClearlyWorse = 1.1;
// Boxes that a proof looks at in a run: `even` and `matrix_blend` need fewer than ten, and `isner`
// more than a night has time for.
constexpr std::uint64_t kProofBoxes = 2000;
constexpr std::string_view kRandomPoses = "random poses";

/// A pose, or a flip on the way to it, that is worth a path of its own.
struct HuntTarget {
  std::string code;
  PoseDegrees from, pose;
  double badness = 0.0;  // of its limit
};

bool is_flip(std::string_view code) { return code == "BB001" || code == "BB002"; }

/// What is found of one rig, in a form that parts of a job can keep.
struct RigHunt {
  PoseHunt hunt;
  CleanVolume volume;
  std::vector<HuntTarget> targets;  // of checks that fail; worst first by code
  std::vector<PoseRecord> samples;
};

json pose_json(const PoseDegrees& pose) {
  json out = json::array();
  for (const std::string_view channel : kChannels) out.push_back(*pose.find(channel));
  return out;
}

PoseDegrees pose_from(const json& value) {
  PoseDegrees pose;
  for (std::size_t c = 0; c < std::size(kChannels); ++c)
    value.at(c).get_to(*pose.find(kChannels[c]));
  return pose;
}

Ledger::Bytes packed(const RigHunt& result) {
  const PoseHunt& h = result.hunt;
  const CleanVolume& v = result.volume;
  json worst = json::array(), targets = json::array(), bodies = json::array();
  for (const HuntedPose& each : h.worst)
    worst.push_back({each.code, each.unit, each.pose, each.value, each.limit, each.over});
  for (const HuntTarget& each : result.targets)
    targets.push_back({each.code, pose_json(each.from), pose_json(each.pose), each.badness});
  for (const PoseRecord& each : result.samples) bodies.push_back(pose_json(each.body));
  return json::to_cbor(
      {{"hunt", {h.evaluations, h.seed, h.box, h.gap, worst, h.notes}},
       {"volume", {v.box, v.proved, v.certified, v.no_jump, v.refuted, v.gain, v.not_proved}},
       {"targets", targets},
       {"bodies", bodies},
       {"samples", json::binary(pack_poses(result.samples))}});
}

PoseRecord planned(const RigRecord& rig, const Envelope& envelope, const PoseDegrees& body) {
  PoseRecord pose;
  pose.body = body;
  pose.inside = envelope.contains(body);
  pose.control = controls_at(*rig.system, body, rig.mapping);
  return pose;
}

RigHunt unpacked(const Ledger::Bytes& bytes, const RigRecord& rig, const Envelope& envelope) {
  const json value = json::from_cbor(bytes);
  RigHunt out;
  const json& h = value.at("hunt");
  out.hunt = {h.at(0), h.at(1), h.at(2), h.at(3), {}, h.at(5)};
  for (const json& each : h.at(4))
    out.hunt.worst.push_back(
        {each.at(0), each.at(1), each.at(2), each.at(3), each.at(4), each.at(5), -1});
  const json& v = value.at("volume");
  out.volume = {v.at(0), v.at(1), v.at(2), v.at(3), v.at(4), v.at(5), v.at(6), 0, 0, 0.0};
  for (const json& each : value.at("targets"))
    out.targets.push_back(
        {each.at(0), pose_from(each.at(1)), pose_from(each.at(2)), each.at(3).get<double>()});
  for (const json& each : value.at("bodies"))
    out.samples.push_back(planned(rig, envelope, pose_from(each)));
  unpack_poses(value.at("samples").get_binary(), out.samples);
  return out;
}

/// How far the sweeps go over the limit of a check inside the envelope: 1 at it.
double worst_of_sweeps(const RigRecord& rig, const JudgeContext& context, const Metric& metric) {
  const Check& check = metric.check();
  double worst = 0.0;
  for (const SweepRecord& sweep : rig.sweeps)
    for (const PoseRecord& pose : sweep.poses) {
      if (!pose.inside || !is_applicable(rig, metric, pose)) continue;
      const double value = pose.at(metric.id).value;
      if (!std::isfinite(value)) continue;
      const double limit = limit_at(check.code, context.limits.of(check.code).value,
                                    compound_load(context.envelope, pose.body));
      worst = std::max(worst, excess(check, value, limit));
    }
  return worst;
}

double largest_jump_of_sweeps(const RigRecord& rig, const JudgeContext& context) {
  double most = 0.0;
  for (const SweepRecord& record : rig.sweeps) {
    const Sweep& sweep = record.sweep;
    for (const Jump& jump : record.flips.jumps)
      if (context.envelope.contains(sweep.pose_at(std::lerp(sweep.from_deg, sweep.to_deg, jump.t))))
        most = std::max(most, jump.size_deg());
  }
  return most;
}

/// What no sweep shows: of poses one a check, of flips the one nearest to rest and the largest.
std::vector<HuntTarget> targets_of(const RigRecord& rig, const JudgeContext& context,
                                   const BoxSearch& search) {
  std::vector<HuntTarget> out;
  const double known_jump = largest_jump_of_sweeps(rig, context);
  const double gain_limit = context.limits.of("BB002").value;
  const double known_gain = worst_of_sweeps(rig, context, *metric_of("BB002"));
  std::vector<HuntTarget> jumps;
  std::optional<HuntTarget> steepest;
  for (const FlipPath& path : search.jumps) {
    if (path.jump_deg > 0.0) {
      if (path.jump_deg > kClearlyWorse * known_jump)
        jumps.push_back({"BB001", path.from, path.to, path.jump_deg});
      continue;
    }
    const double badness = path.gain / gain_limit;
    if (badness > std::max(1.0, kClearlyWorse * known_gain) &&
        (!steepest || badness > steepest->badness))
      steepest = HuntTarget{"BB002", path.from, path.to, badness};
  }
  if (!jumps.empty()) {
    const auto largest = std::ranges::max_element(jumps, {}, &HuntTarget::badness);
    out.push_back(jumps.front());  // they come by their distance from rest
    if (largest != jumps.begin()) out.push_back(*largest);
  }
  if (steepest) out.push_back(*steepest);
  for (const HuntWorst& each : search.worst) {
    const Check& check = *find_check(each.code);
    if (judge(check, each.value, each.limit) != Verdict::fail) continue;
    const double badness = excess(check, each.value, each.limit);
    const double known = worst_of_sweeps(rig, context, *metric_of(each.code));
    if (known <= 1.0 || badness > kClearlyWorse * known)
      out.push_back({each.code, {}, each.pose, badness});
  }
  return out;
}

/// What a proof says of the joints over the box of an envelope.
CleanVolume proved_volume(const Stage& stage, const RigRecord& rig, const JudgeContext& context,
                          const ControlBox& box) {
  CleanVolume out;
  out.box = box.text();
  if (is_external(rig.plan.spec)) {
    out.not_proved = "a rig of your own is not proved";
    return out;
  }
  ProofBox proved{"envelope", false, {{"extension", 0, 0}, {"side", 0, 0}, {"twist", 0, 0}}};
  for (const BoxAxis& axis : box.axes)
    for (ProofAxis& each : proved.axis)
      if (each.channel == axis.name || (each.channel == "extension" && axis.name == "bend"))
        each = {each.channel, axis.low, axis.high};
  ProofQuestion question{rig.plan.spec, stage.rest_chain(), rig.mapping, proved};
  question.gain = out.gain = context.limits.of("BB002").value;
  question.boxes = kProofBoxes;
  try {
    box_solver_of(*rig.system);
    check_box(proved, rig.plan.name);
    ProofTree tree;
    Progress silent(Progress::Style::none);
    prove(question, *rig.system, tree, silent);
    const ProofShares shares = shares_of(tree, proved);
    if (shares.no_jump == 0.0 && shares.refuted == 0.0) {
      out.not_proved = std::string(rig.system->name()) + ": " + std::to_string(kProofBoxes) +
                       " boxes decide nothing of it; backbend prove looks at more";
      return out;
    }
    out.proved = true;
    out.certified = shares.certified;
    out.no_jump = shares.no_jump;
    out.refuted = shares.refuted;
  } catch (const ProofError& error) {
    out.not_proved = error.what();
  }
  return out;
}

RigHunt hunted(const HuntedCharacter& character, const HuntPlan& plan, const RigRecord& rig,
               std::size_t evaluations, const std::function<void(std::size_t)>& on_step) {
  RigHunt out;
  out.hunt.seed = plan.seed;
  const JudgeContext& context = character.context_of(rig);
  try {
    HuntSettings settings{box_within(context.envelope, character.sweeps), ""};
    settings.evaluations = evaluations;
    settings.seed = static_cast<std::uint64_t>(plan.seed);
    settings.samples =
        std::max(static_cast<std::size_t>(std::ceil(kSampled * static_cast<double>(evaluations))),
                 std::min(evaluations, static_cast<std::size_t>(plan.samples)));
    const HuntScene scene{character.stage, character.body, context.envelope,  context.limits,
                          rig.plan,        rig.mapping,    context.character, nullptr};
    BoxSearch search = search_poses(scene, settings, on_step);
    out.volume = proved_volume(character.stage, rig, context, search.box);
    out.samples = std::move(search.samples);
    if (plan.percent <= 0.0) return out;  // the random poses were asked for alone
    out.hunt.evaluations = static_cast<int>(search.evaluations);
    out.hunt.box = search.box.text();
    out.hunt.gap = search.gap_volume;
    out.hunt.notes = search.notes;
    for (const HuntWorst& each : search.worst) {
      const Check& check = *find_check(each.code);
      out.hunt.worst.push_back({each.code, std::string(check.unit), each.pose.text(), each.value,
                                each.limit, judge(check, each.value, each.limit) == Verdict::fail,
                                -1});
    }
    out.targets = targets_of(rig, context, search);
  } catch (const solver::RigError& error) {  // it remembers earlier poses, or moves nothing here
    out.hunt.notes.emplace_back(error.what());
  } catch (const ReadError& error) {
    out.hunt.notes.emplace_back(error.what());
  }
  return out;
}

/// The paths to what no sweep shows, planned; what the hunt saw is told which path shows it, where
/// they follow the rig's own sweeps.
std::vector<Sweep> paths_to(const RigRecord& rig, const std::vector<HuntTarget>& targets,
                            PoseHunt& hunt) {
  std::vector<Sweep> out;
  std::vector<std::string> known;  // from and to of each
  for (const HuntTarget& target : targets) {
    const std::string words = pose_words(target.from) + ">" + pose_words(target.pose);
    const auto place = static_cast<std::size_t>(std::ranges::find(known, words) - known.begin());
    if (place == known.size()) {
      int number = 1;
      while (std::ranges::find(out, hunt_name(rig, target.code, number), &Sweep::name) != out.end())
        ++number;
      out.push_back(named_pose(hunt_name(rig, target.code, number), target.from, target.pose));
      out.back().corner = false;  // chosen for being bad: no fair part of the corners' share
      known.push_back(words);
    }
    const int sweep = static_cast<int>(rig.sweeps.size() + place);
    const auto seen = std::ranges::find(hunt.worst, target.code, &HuntedPose::code);
    if (seen != hunt.worst.end() && !is_flip(target.code)) {
      seen->sweep = sweep;
    } else {
      // It lies on the way, and has no value before the way is measured.
      const double nan = std::numeric_limits<double>::quiet_NaN();
      hunt.worst.push_back({target.code, std::string(find_check(target.code)->unit),
                            target.pose.text(), nan, nan, true, sweep});
    }
  }
  return out;
}

std::size_t poses_of(const RigRecord& rig) {
  std::size_t poses = 0;
  for (const SweepRecord& sweep : rig.sweeps)
    for (const PoseRecord& pose : sweep.poses) poses += pose.taken ? 1 : 0;
  return poses;
}

}  // namespace

std::string hunt_name(const RigRecord& rig, const std::string& code, int number) {
  return "hunt " + rig.plan.name + " " + code + (number > 1 ? " " + std::to_string(number) : "");
}

bool hunt_rigs(const HuntedCharacter& character, const HuntPlan& plan,
               std::vector<RigRecord>& records, Ledger& ledger, Progress& progress) {
  if (plan.percent <= 0.0 && plan.samples <= 0) return true;
  std::vector<std::size_t> evaluations;
  std::size_t in_all = 0;
  for (const RigRecord& rig : records) {
    const auto share = static_cast<std::size_t>(
        std::ceil(plan.percent / 100.0 * static_cast<double>(poses_of(rig))));
    evaluations.push_back(std::max(share, static_cast<std::size_t>(plan.samples)));
    in_all += evaluations.back();
  }
  progress.start("poses of the search", in_all);
  std::vector<std::optional<RigHunt>> result(records.size());
  std::atomic<bool> complete = true;
  const auto search = [&](std::size_t i) {
    poll_interrupt();
    const RigRecord& rig = records[i];
    const std::string unit = unit_name("hunt", character.content, rig, "", 0);
    if (const auto found = ledger.find(unit)) {
      result[i] = unpacked(*found, rig, character.context_of(rig).envelope);
      progress.step(evaluations[i]);
    } else if (ledger.mode() == Ledger::Mode::merge) {
      ledger.miss(unit);
      complete = false;
    } else {
      result[i] = hunted(character, plan, rig, evaluations[i],
                         [&](std::size_t count) { progress.step(count); });
      ledger.keep(unit, packed(*result[i]));
    }
  };
  // In a shard its own share comes first, then what the others have not finished. A studio's own
  // rigs are asked one after the other.
  for (const bool own : {true, false}) {
    oneapi::tbb::parallel_for(std::size_t{0}, records.size(), [&](std::size_t i) {
      if (!result[i] && ledger.makes(i) == own && !is_external(records[i].plan.spec)) search(i);
    });
    for (std::size_t i = 0; i < records.size(); ++i)
      if (!result[i] && ledger.makes(i) == own && is_external(records[i].plan.spec)) search(i);
  }
  if (!complete) return false;

  std::vector<RigRecord> paths;
  std::vector<std::size_t> of;  // the record that each belongs to
  std::size_t poses = 0;
  for (std::size_t i = 0; i < records.size(); ++i) {
    RigRecord& rig = records[i];
    rig.hunt = std::move(result[i]->hunt);
    rig.volume = std::move(result[i]->volume);
    rig.samples = std::move(result[i]->samples);
    const std::vector<Sweep> sweeps = paths_to(rig, result[i]->targets, rig.hunt);
    if (sweeps.empty()) continue;
    paths.push_back(plan_rig(character.stage, character.body, rig.plan, rig.mapping, sweeps,
                             character.context_of(rig).envelope));
    of.push_back(i);
    for (SweepRecord& sweep : paths.back().sweeps)
      for (PoseRecord& pose : sweep.poses) {
        pose.rest_noted = false;  // the rig's own sweeps have that pose
        ++poses;
      }
  }
  progress.start("poses of the finds", poses);
  if (!measure_records(character.stage, character.body, character.content, paths, ledger, progress))
    return false;
  for (std::size_t k = 0; k < paths.size(); ++k)
    std::ranges::move(paths[k].sweeps, std::back_inserter(records[of[k]].sweeps));
  for (RigRecord& rig : records) confirm_flips(rig, character.context_of(rig).limits);
  return true;
}

void confirm_flips(RigRecord& rig, const LimitSet& limits) {
  std::set<int, std::greater<>> in_vain;  // the last first
  std::erase_if(rig.hunt.worst, [&](HuntedPose& each) {
    if (each.sweep < 0 || !is_flip(each.code)) return false;
    const SweepRecord& path = rig.sweeps[static_cast<std::size_t>(each.sweep)];
    each.value = 0.0;
    if (each.code == "BB001") {
      for (const Jump& jump : path.flips.jumps) {
        if (jump.size_deg() <= each.value) continue;
        each.value = jump.size_deg();
        each.pose =
            path.sweep.pose_at(std::lerp(path.sweep.from_deg, path.sweep.to_deg, jump.t)).text();
      }
    } else {
      for (const PoseRecord& pose : path.poses) {
        const double gain = pose.at(MetricId::gain).value;
        if (!(gain > each.value)) continue;
        each.value = gain;
        each.pose = pose.body.text();
      }
    }
    each.limit = limits.of(each.code).value;
    if (judge(*find_check(each.code), each.value, each.limit) == Verdict::fail) return false;
    in_vain.insert(each.sweep);
    return true;
  });
  for (const int path : in_vain) {
    if (std::ranges::find(rig.hunt.worst, path, &HuntedPose::sweep) != rig.hunt.worst.end())
      continue;
    rig.sweeps.erase(rig.sweeps.begin() + path);
    for (HuntedPose& each : rig.hunt.worst) each.sweep -= each.sweep > path ? 1 : 0;
  }
  std::ranges::stable_sort(rig.hunt.worst, {}, &HuntedPose::code);
}

void judge_samples(const Stage& stage, const BodyMetrics& body, bool judges_weights,
                   const JudgeContext& context, RigRecord& rig) {
  if (rig.samples.empty()) return;
  // A path whose corners are the poses: what is said of a sweep can be said of them.
  std::vector<PoseDegrees> corners(1);
  for (const PoseRecord& pose : rig.samples) corners.push_back(pose.body);
  SweepRecord record;
  record.sweep = path_sweep(std::string(kRandomPoses), corners, 1.0);
  record.poses = std::move(rig.samples);
  const std::vector<Waypoint>& at = record.sweep.through;
  for (std::size_t i = 0; i < record.poses.size(); ++i)
    record.poses[i].control_deg = at[std::min(i + 1, at.size() - 1)].control_deg;
  std::vector<SweepRecord> own(1);
  own.front() = std::move(record);
  std::swap(rig.sweeps, own);
  std::vector<Finding> findings = judge_rig(rig, context);
  book_owners(stage, body, rig, judges_weights, findings);
  const SweepRecord& sampled = rig.sweeps.front();
  rig.volume.poses = static_cast<int>(sampled.poses.size());
  rig.volume.clean = clean_poses(rig, sampled, context, findings);
  rig.volume.at_least = least_share(rig.volume.clean, rig.volume.poses, kVolumeConfidence);
  std::swap(rig.sweeps, own);
  rig.samples = std::move(own.front().poses);
}

void drop_repeats(const RigRecord& rig, std::vector<Finding>& findings) {
  const auto is_hunted = [&](const Finding& finding) {
    return finding.at.sweep >= 0 && std::ranges::find(rig.hunt.worst, finding.at.sweep,
                                                      &HuntedPose::sweep) != rig.hunt.worst.end();
  };
  const auto is_after = [&](const Finding& finding) {
    return std::ranges::any_of(rig.hunt.worst, [&](const HuntedPose& each) {
      return each.sweep == finding.at.sweep && each.code == finding.code;
    });
  };
  const auto badness = [](const Finding& finding) {
    return excess(*find_check(finding.code), finding.value, finding.limit);
  };
  const std::vector<Finding> all = findings;
  std::erase_if(findings, [&](const Finding& finding) {
    if (!is_hunted(finding) || is_after(finding)) return false;
    return std::ranges::any_of(all, [&](const Finding& other) {
      return other.code == finding.code && other.at.sweep != finding.at.sweep &&
             (is_after(other) || !is_hunted(other)) &&
             (other.inside_envelope || !finding.inside_envelope) &&
             kClearlyWorse * badness(other) >= badness(finding);
    });
  });
}

}  // namespace backbend::validate
