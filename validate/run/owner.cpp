#include "validate/run/owner.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <limits>
#include <map>
#include <utility>

#include "validate/metrics/proxy_weights.h"
#include "validate/run/ideal_bend.h"
#include "validate/verdicts/booking.h"

namespace backbend::validate {
namespace {

PoseDegrees pose_of(const RigRecord& rig, const Finding& finding) {
  const auto sweep =
      std::find_if(rig.sweeps.begin(), rig.sweeps.end(),
                   [&](const SweepRecord& each) { return each.sweep.name == finding.sweep; });
  return sweep->sweep.pose_at(finding.control_deg);
}

/// Solves and measures single poses again, by other means than the run did.
class SecondOpinions {
 public:
  SecondOpinions(const Stage& stage, const BodyMetrics& body, const RigRecord& rig)
      : stage_(stage), body_(body), rig_(rig), even_(stage.build({"even", {}})) {}

  /// Before the first proxy() or ideal_proxy(), which are nothing without.
  void make_proxy() {
    const auto weights =
        proxy_weights(stage_.character(), stage_.anatomy(), stage_.driver(), stage_.rest());
    if (!weights) return;
    proxy_ = stage_.character();
    proxy_->influences = *weights;
  }

  /// Under `even`: the ideal bend and twist with the same ends and the same weights.
  PoseRecord ideal(const PoseDegrees& pose) const {
    const IdealBend ideal(pose);
    if (ideal.spec.options.empty())
      return measured(*even_, ideal.pose, skin::SkinningMethod::linear, stage_.character());
    return measured(*stage_.build(ideal.spec), ideal.pose, skin::SkinningMethod::linear,
                    stage_.character());
  }
  PoseRecord dual_quaternion(const PoseDegrees& pose) const {
    return measured(*rig_.system, pose, skin::SkinningMethod::dual_quaternion, stage_.character());
  }
  /// The same rig with clean proxy weights; every metric NaN where there can be none.
  PoseRecord proxy(const PoseDegrees& pose) const {
    if (!proxy_) return {};
    return measured(*rig_.system, pose, skin::SkinningMethod::linear, *proxy_);
  }
  /// `even` with clean proxy weights: what this skeleton can do at its best.
  PoseRecord ideal_proxy(const PoseDegrees& pose) const {
    if (!proxy_) return {};
    const IdealBend ideal(pose);
    return measured(*stage_.build(ideal.spec), ideal.pose, skin::SkinningMethod::linear, *proxy_);
  }

 private:
  PoseRecord measured(const solver::SpineSystem& system, const PoseDegrees& pose,
                      skin::SkinningMethod method, const skin::Character& character) const {
    PoseRecord record;
    record.body = pose;
    record.control = controls_at(system, pose, rig_.mapping);
    PosedCharacter posed;
    posed.spine = system.solve(record.control);
    posed.world_from_node = stage_.driver().drive(system, posed.spine);
    posed.mesh = skin::skin(character, posed.world_from_node, method);
    measure_pose(body_, rig_at_rest(system), posed, record);
    return record;
  }

  const Stage& stage_;
  const BodyMetrics& body_;
  const RigRecord& rig_;
  std::unique_ptr<solver::SpineSystem> even_;
  std::optional<skin::Character> proxy_;
};

/// `0.94, which passes`: a value that somebody else would give, and what it would mean.
std::string verdict_text(const Check& check, double value, double limit) {
  return number_text(value, 3) + (judge(check, value, limit) == Verdict::pass ? " (passes)" : "");
}

/// `5 joints cannot carry this pose within the limit: about 9 would`
std::string skeleton_text(const Stage& stage, const Check& check, const Finding& finding,
                          double clean) {
  const int joints = static_cast<int>(stage.anatomy().chest_index) + 1;
  const int needed = joints_needed(check, finding.limit, clean, joints);
  return std::to_string(joints) + " joints cannot carry " + finding.pose + " here" +
         (needed > joints ? ": about " + std::to_string(needed) + " would" : "") +
         "; advisory: clean weights and the ideal bend show it, too";
}

/// What the ideal bend of the same rest spine shows as well belongs to the skeleton, and is
/// advisory.
void book_rest_shape(const Check& check, double ideal, Finding& finding) {
  if (!is_rest_shape(check, finding.limit, finding.value, ideal)) return;
  finding.owner = Owner::skeleton;
  finding.verdict = Verdict::stress;
  finding.detail +=
      "; advisory: the rest spine turns so sharply there that the ideal bend shows it, too";
}

}  // namespace

void book_owners(const Stage& stage, const BodyMetrics& body, const RigRecord& rig,
                 bool judges_weights, std::vector<Finding>& findings) {
  SecondOpinions opinions(stage, body, rig);
  const bool is_ideal = rig.plan.spec.system == "even" && rig.plan.spec.options.empty();
  // A pose of a sweep is solved again once, however many findings name it.
  struct Opinions {
    bool on_mesh = false;
    PoseDegrees pose;
    PoseRecord ideal, proxy, ideal_proxy, dual;
  };
  std::map<std::pair<std::string, double>, Opinions> by_pose;
  bool any_on_mesh = false;
  for (const Finding& finding : findings) {
    const Check& check = *find_check(finding.code);
    if (!metric_of(finding.code)) continue;
    const bool on_mesh = check.subject == Subject::mesh;
    if (!on_mesh && is_ideal) continue;  // it is its own ideal
    Opinions& each = by_pose[{finding.sweep, finding.control_deg}];
    each.pose = pose_of(rig, finding);
    each.on_mesh = each.on_mesh || on_mesh;
    any_on_mesh = any_on_mesh || on_mesh;
  }
  if (any_on_mesh) opinions.make_proxy();
  std::vector<Opinions*> todo;
  for (auto& [place, each] : by_pose) todo.push_back(&each);
  oneapi::tbb::parallel_for(std::size_t{0}, todo.size(), [&](std::size_t i) {
    Opinions& each = *todo[i];
    each.ideal = opinions.ideal(each.pose);
    if (!each.on_mesh) return;
    each.proxy = opinions.proxy(each.pose);
    each.ideal_proxy = is_ideal ? each.proxy : opinions.ideal_proxy(each.pose);
    each.dual = opinions.dual_quaternion(each.pose);
  });
  for (Finding& finding : findings) {
    const Check& check = *find_check(finding.code);
    const auto metric = metric_of(finding.code);
    const auto found = by_pose.find({finding.sweep, finding.control_deg});
    const bool on_mesh = check.subject == Subject::mesh;
    if (metric && !on_mesh && is_ideal) book_rest_shape(check, finding.value, finding);
    if (!metric || found == by_pose.end() || (!on_mesh && is_ideal)) continue;
    const Opinions& each = found->second;
    const double ideal = each.ideal.at(*metric).value;
    if (!on_mesh) {
      if (!std::isfinite(ideal)) continue;  // asked of pairs of poses, not of one
      finding.geometry["ideal"] = ideal;
      finding.detail += "; the rig " + rig_text(IdealBend(each.pose).spec) + " gives " +
                        verdict_text(check, ideal, finding.limit) + " in the same pose";
      book_rest_shape(check, ideal, finding);
      continue;
    }
    MeshContext facts;
    facts.value = finding.value;
    facts.ideal = ideal;
    facts.proxy = each.proxy.at(*metric).value;
    facts.ideal_proxy = each.ideal_proxy.at(*metric).value;
    facts.infeasible = each.ideal.at(MetricId::feasibility).value;
    facts.judging_weights = judges_weights;
    facts.bones = static_cast<int>(stage.anatomy().chest_index);
    const Booking booking = book_mesh_finding(check, finding.limit, facts);
    finding.owner = booking.owner;
    if (!booking.decides) finding.verdict = Verdict::stress;
    const double dual = each.dual.at(*metric).value;
    finding.geometry["ideal"] = facts.ideal;
    finding.geometry["dual_quaternion"] = dual;
    finding.detail += "; the ideal bend gives " + verdict_text(check, facts.ideal, finding.limit) +
                      ", dual quaternions would give " + verdict_text(check, dual, finding.limit);
    if (std::isfinite(facts.proxy)) {
      finding.geometry["proxy_weights"] = facts.proxy;
      finding.detail +=
          ", automatic test weights " + verdict_text(check, facts.proxy, finding.limit);
    }
    if (booking.owner == Owner::skeleton)
      finding.detail += "; " + skeleton_text(stage, check, finding, facts.ideal_proxy);
    if (booking.owner == Owner::pose) {
      finding.detail += "; too thick to bend this far, no fault of the rig";
    }
  }
}

}  // namespace backbend::validate
