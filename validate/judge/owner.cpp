#include "validate/judge/owner.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <limits>
#include <map>
#include <utility>

#include "validate/judge/torso_facts.h"
#include "validate/live/external_rig.h"
#include "validate/metrics/surface/proxy_weights.h"
#include "validate/stage/equal_shares.h"
#include "validate/stage/ideal_bend.h"
#include "validate/verdicts/booking.h"

namespace backbend::validate {
namespace {

/// Solves and measures single poses again with other rigs, weights or skinning.
class SecondOpinions {
 public:
  SecondOpinions(const Stage& stage, const BodyMetrics& body, const RigRecord& rig)
      : stage_(stage),
        body_(body),
        rig_(rig),
        even_(rig.recording ? nullptr : stage.build({"even", {}})) {}

  /// Must be called before proxy() or ideal_proxy().
  void make_proxy() {
    const auto weights =
        proxy_weights(stage_.character(), stage_.anatomy(), stage_.driver(), stage_.rest());
    if (!weights) return;
    proxy_ = stage_.character();
    proxy_->influences = *weights;
  }

  /// Under `even`: the ideal bend and twist with the same ends and the same weights.
  PoseRecord ideal(const PoseDegrees& pose, Crossing crossing) const {
    const IdealBend ideal(pose);
    if (ideal.spec.options.empty())
      return measured(*even_, ideal.pose, skin::SkinningMethod::linear, stage_.character(),
                      crossing);
    return measured(*stage_.build(ideal.spec), ideal.pose, skin::SkinningMethod::linear,
                    stage_.character(), crossing);
  }
  PoseRecord dual_quaternion(const PoseDegrees& pose, Crossing crossing) const {
    return measured(*rig_.system, pose, skin::SkinningMethod::dual_quaternion, stage_.character(),
                    crossing);
  }
  /// Linear blending of the same joints, where the rig gives its own points; every metric NaN
  /// where it does not.
  PoseRecord blended(const PoseDegrees& pose, Crossing crossing) const {
    const ExternalRig* external = external_rig(*rig_.system);
    if (!external || !external->gives_points()) return {};
    return measured(*rig_.system, pose, skin::SkinningMethod::linear, stage_.character(), crossing);
  }
  /// The same rig with clean proxy weights; every metric NaN where there can be none.
  PoseRecord proxy(const PoseDegrees& pose, Crossing crossing) const {
    if (!proxy_) return {};
    return measured(*rig_.system, pose, skin::SkinningMethod::linear, *proxy_, crossing);
  }
  /// `even` with clean proxy weights: what this skeleton can do at its best.
  PoseRecord ideal_proxy(const PoseDegrees& pose, Crossing crossing) const {
    if (!proxy_) return {};
    const IdealBend ideal(pose);
    return measured(*stage_.build(ideal.spec), ideal.pose, skin::SkinningMethod::linear, *proxy_,
                    crossing);
  }
  /// The chest where a rig of the studio's has it, every joint of the spine turned alike; with
  /// clean proxy weights, too. Every metric NaN for rigs of ours, which are held against the ideal
  /// bend.
  PoseRecord equal_shares(const PoseDegrees& pose, Crossing crossing) const {
    return shared(pose, stage_.character(), crossing);
  }
  PoseRecord equal_shares_proxy(const PoseDegrees& pose, Crossing crossing) const {
    return proxy_ ? shared(pose, *proxy_, crossing) : PoseRecord{};
  }

 private:
  PoseRecord shared(const PoseDegrees& pose, const skin::Character& character,
                    Crossing crossing) const {
    if (!external_rig(*rig_.system)) return {};
    const auto spine = with_equal_shares(
        stage_, rig_.system->solve(controls_at(*rig_.system, pose, rig_.mapping)));
    if (!spine) return {};
    return measured(*rig_.system, *spine, pose, skin::SkinningMethod::linear, character, crossing);
  }
  PoseRecord measured(const solver::SpineSystem& system, const PoseDegrees& pose,
                      skin::SkinningMethod method, const skin::Character& character,
                      Crossing crossing) const {
    return measured(system, system.solve(controls_at(system, pose, rig_.mapping)), pose, method,
                    character, crossing);
  }
  PoseRecord measured(const solver::SpineSystem& system, solver::SpinePose spine,
                      const PoseDegrees& pose, skin::SkinningMethod method,
                      const skin::Character& character, Crossing crossing) const {
    PoseRecord record;
    record.body = pose;
    record.control = controls_at(system, pose, rig_.mapping);
    PosedCharacter posed;
    if (&character == &stage_.character()) {
      // Of the joints, not of the points that a rig of the studio's may give.
      posed = stage_.pose(system, std::move(spine), method);
    } else {
      posed.spine = std::move(spine);
      posed.mesh = skin::skin(character, stage_.driver().drive(system, posed.spine), method);
    }
    measure_pose(body_, rig_at_rest(system), posed, record, crossing);
    return record;
  }

  const Stage& stage_;
  const BodyMetrics& body_;
  const RigRecord& rig_;
  std::unique_ptr<solver::SpineSystem> even_;
  std::optional<skin::Character> proxy_;
};

/// `0.94, which passes`: a value of another rig or method, and its verdict.
std::string verdict_text(const Check& check, double value, double limit) {
  return number_text(value, 3) + (judge(check, value, limit) == Verdict::pass ? " (passes)" : "");
}

constexpr int kMostSpineJoints = 33;  // a human's vertebrae; nobody would build more

/// `5 joints cannot carry this pose within the limit: about 9 would`
std::string skeleton_text(const Stage& stage, const Check& check, const Finding& finding,
                          double clean, const std::string& reference) {
  const int joints = static_cast<int>(stage.anatomy().chest_index) + 1;
  const int needed = joints_needed(check, finding.limit, clean, joints);
  const bool clean_shows_it = judge(check, clean, finding.limit) == Verdict::fail;
  return std::to_string(joints) + " joints cannot carry " + finding.pose + " here" +
         (needed > joints && needed <= kMostSpineJoints
              ? ": about " + std::to_string(needed) + " would"
              : "") +
         "; advisory: " +
         (clean_shows_it ? "clean weights and " + reference + " show it, too"
                         : reference + " shows it, too");
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

constexpr std::string_view kTooThick = "; too thick to bend this far, no fault of the rig";

/// What is a solver's of a rig is that of whoever made the motion, of a recording.
void book_motion(Owner of_motion, const Finding& finding, const MeshContext& facts,
                 Booking& booking) {
  // A clip moves the limbs on purpose, and what turns over at their roots turns over under the even
  // bend as well. Areas add up: the spine's own share is what is left.
  if (finding.code == "BB033" && booking.owner == Owner::solver &&
      facts.value - facts.ideal <= finding.limit)
    booking = {booking.verdict, Owner::weights, false};
  if (booking.owner == Owner::solver) booking.owner = of_motion;
  // Captured or keyed motion bends the skin as intended, and what an even bend would show better
  // decides nothing; but nobody intends a joint twisted until the skin around it is a string.
  constexpr double kString = 0.5;  // of the limit, and of what the even bend leaves
  const bool is_string = finding.code == "BB030" && facts.value < kString * finding.limit &&
                         facts.value < kString * facts.ideal;
  if (booking.owner == Owner::motion) booking.decides = is_string;
}

}  // namespace

void book_owners(const Stage& stage, const BodyMetrics& body, const RigRecord& rig,
                 bool judges_weights, std::vector<Finding>& findings) {
  SecondOpinions opinions(stage, body, rig);
  const bool is_ideal = rig.plan.spec.system == "even" && rig.plan.spec.options.empty();
  // A pose of a sweep is solved again once, however many findings name it.
  struct Opinions {
    bool on_mesh = false;
    Crossing crossing = Crossing::left_out;  // unless a finding is of them
    PoseDegrees pose;
    const PoseRecord* recorded = nullptr;
    PoseRecord ideal, proxy, ideal_proxy, dual, blended, shared, shared_proxy;
  };
  // Of a recording by its frame: a control may come back to a value.
  const auto place_of = [&](const Finding& finding) {
    return std::pair(finding.at.sweep, rig.recording ? finding.at.pose : finding.control_deg);
  };
  std::map<std::pair<int, double>, Opinions> by_pose;
  bool any_on_mesh = false;
  for (const Finding& finding : findings) {
    const Check& check = *find_check(finding.code);
    const Metric* metric = metric_of(finding.code);
    if (metric == nullptr) continue;
    const bool on_mesh = check.subject == Subject::mesh;
    if (!on_mesh && (is_ideal || rig.recording)) continue;  // it is its own ideal
    Opinions& each = by_pose[place_of(finding)];
    if (rig.recording)
      each.recorded = &sweep_of(rig, finding)->poses[static_cast<std::size_t>(finding.at.pose)];
    else
      each.pose = sweep_of(rig, finding)->sweep.pose_at(finding.control_deg);
    each.on_mesh = each.on_mesh || on_mesh;
    if (metric->id == MetricId::self_intersection) each.crossing = Crossing::measured;
    any_on_mesh = any_on_mesh || on_mesh;
  }
  // A recording is compared with its own frames bent evenly, and with nothing else.
  const bool solved_on_mesh = any_on_mesh && !rig.recording;
  if (solved_on_mesh) opinions.make_proxy();
  const double rows = solved_on_mesh && stage.anatomy().chest_index > 0
                          ? rows_per_bone(stage)
                          : std::numeric_limits<double>::infinity();
  const double longest = rig.recording ? 0.0 : longest_bone(stage);
  const bool in_pieces = solved_on_mesh && torso_in_pieces(stage);
  std::vector<Opinions*> todo;
  for (auto& [place, each] : by_pose) todo.push_back(&each);
  oneapi::tbb::parallel_for(std::size_t{0}, todo.size(), [&](std::size_t i) {
    Opinions& each = *todo[i];
    if (each.recorded != nullptr) {
      each.ideal = rig.recording->even_bend(*each.recorded);
      return;
    }
    each.ideal = opinions.ideal(each.pose, each.crossing);
    if (!each.on_mesh) return;
    each.proxy = opinions.proxy(each.pose, each.crossing);
    each.ideal_proxy = is_ideal ? each.proxy : opinions.ideal_proxy(each.pose, each.crossing);
    each.dual = opinions.dual_quaternion(each.pose, each.crossing);
    each.blended = opinions.blended(each.pose, each.crossing);
    each.shared = opinions.equal_shares(each.pose, each.crossing);
    each.shared_proxy = opinions.equal_shares_proxy(each.pose, each.crossing);
  });
  for (Finding& finding : findings) {
    const Check& check = *find_check(finding.code);
    const Metric* metric = metric_of(finding.code);
    const auto found = by_pose.find(place_of(finding));
    const bool on_mesh = check.subject == Subject::mesh;
    if (metric != nullptr && !on_mesh && is_ideal) book_rest_shape(check, finding.value, finding);
    if (metric == nullptr || found == by_pose.end()) continue;
    if (!on_mesh && (is_ideal || rig.recording)) continue;
    const Opinions& each = found->second;
    const double ideal = each.ideal.at(metric->id).value;
    if (!on_mesh) {
      if (!std::isfinite(ideal)) continue;  // asked of pairs of poses, not of one
      finding.geometry["ideal"] = ideal;
      finding.detail += "; the rig " + rig_text(IdealBend(each.pose).spec) + " gives " +
                        verdict_text(check, ideal, finding.limit) + " in the same pose";
      book_rest_shape(check, ideal, finding);
      continue;
    }
    if (const double blended = each.blended.at(metric->id).value; std::isfinite(blended)) {
      finding.geometry["linear_blending"] = blended;
      finding.detail += "; linear blending of the same joints gives " +
                        verdict_text(check, blended, finding.limit);
      if (judge(check, blended, finding.limit) == Verdict::pass) {
        finding.owner = Owner::rig;
        finding.detail += ": the rig's deformers make it";
        continue;
      }
    }
    MeshContext facts;
    facts.value = finding.value;
    facts.ideal = ideal;
    facts.proxy = each.proxy.at(metric->id).value;
    facts.ideal_proxy = each.ideal_proxy.at(metric->id).value;
    // `even` also turns the hips' bone and distributes by arc length. Turning each joint above the
    // hips equally is as sound, so what that shows as well is not a fault of the rig.
    const double shared = each.shared.at(metric->id).value;
    const bool plain_is_worse =
        check.sense == Sense::at_most ? shared > ideal : shared < ideal;  // false where NaN
    if (plain_is_worse) {
      facts.ideal = shared;
      facts.ideal_proxy = each.shared_proxy.at(metric->id).value;
    }
    facts.own_shares = std::isfinite(shared);
    facts.infeasible = each.ideal.at(MetricId::feasibility).value;
    facts.judging_weights = judges_weights;
    facts.bones = rig.recording ? 0 : static_cast<int>(stage.anatomy().chest_index);
    facts.longest_bone = longest;
    facts.rows_per_bone = rows;
    facts.in_pieces = in_pieces;
    Booking booking = book_mesh_finding(check, finding.limit, facts);
    if (rig.recording) book_motion(rig.recording->owner, finding, facts, booking);
    finding.owner = booking.owner;
    if (!booking.decides) finding.verdict = Verdict::stress;
    finding.geometry["ideal"] = ideal;
    if (rig.recording) {
      finding.detail += "; an even bend with the same ends gives " + number_text(ideal, 3);
      if (booking.owner == Owner::pose) finding.detail += kTooThick;
      continue;
    }
    const double dual = each.dual.at(metric->id).value;
    finding.geometry["dual_quaternion"] = dual;
    finding.detail += "; the ideal bend gives " + verdict_text(check, ideal, finding.limit);
    if (std::isfinite(shared)) {
      finding.geometry["equal_shares"] = shared;
      finding.detail +=
          ", an equal share of each joint " + verdict_text(check, shared, finding.limit);
    }
    finding.detail += ", dual quaternions would give " + verdict_text(check, dual, finding.limit);
    if (std::isfinite(facts.proxy)) {
      finding.geometry["proxy_weights"] = facts.proxy;
      finding.detail +=
          ", automatic test weights " + verdict_text(check, facts.proxy, finding.limit);
    }
    if (booking.owner == Owner::weights && !booking.decides && judges_weights && check.decides)
      finding.detail += "; advisory: what weights alone do decides from " +
                        number_text(weights_limit(check, finding.limit), 3) + " on";
    if (booking.owner == Owner::skeleton && rows < kLeastRowsForSlices)
      finding.detail += "; the surface has " + number_text(rows, 2) + " vertices along each bone";
    if (booking.owner == Owner::skeleton && in_pieces)
      finding.detail += "; the torso is of pieces that no edges join, which go their own ways";
    if (booking.owner == Owner::skeleton)
      finding.detail += "; " + skeleton_text(stage, check, finding, facts.ideal_proxy,
                                             plain_is_worse ? "an equal share" : "the ideal bend");
    if (booking.owner == Owner::pose) finding.detail += kTooThick;
  }
}

}  // namespace backbend::validate
