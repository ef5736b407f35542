#include "validate/night/image_pass.h"

#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>

#include "validate/evidence/image_witness.h"
#include "validate/live/external_rig.h"
#include "validate/measure/arm_pose.h"
#include "validate/measure/measure_job.h"
#include "validate/metrics/math/median.h"
#include "validate/metrics/surface/proxy_weights.h"
#include "validate/stage/ideal_bend.h"
#include "validate/tasks/side_by_side.h"

namespace backbend::validate {
namespace {

const Check& check_of(const Finding& finding) { return *find_check(finding.code); }

/// The findings that get a picture witness, worst first and limited in number: a body that fails
/// everywhere fails at the end of every sweep in the same way.
std::vector<bool> worst_of_each_code(const std::vector<Finding>& findings) {
  constexpr int kOfACode = 6;
  std::map<std::string, int> seen;
  std::vector<bool> shown;
  for (const Finding& finding : findings) shown.push_back(seen[finding.code]++ < kOfACode);
  return shown;
}

/// Whether two rigid motions are equal up to rounding.
bool moves_alike(const solver::RigidMotion& a, const solver::RigidMotion& b) {
  constexpr double kRounding = 1e-9;
  return std::abs(glm::dot(a.turn, b.turn)) >= 1.0 - kRounding &&
         glm::distance(a.apply(a.rest_origin), b.apply(a.rest_origin)) <= kRounding;
}

/// How much of a finding its pictures can show: what it has more than the pose that they were held
/// against.
double seen_size(const Finding& finding) {
  if (check_of(finding).pictures != Witness::kink) return finding.value;
  const bool by_weights = finding.image.note.find("proxy weights") != std::string::npos;
  const auto other = finding.geometry.find(by_weights ? "proxy_weights" : "ideal");
  return other == finding.geometry.end() || !std::isfinite(other->second)
             ? finding.value
             : finding.value - other->second;
}

/// Whether the path itself changes its direction within the two steps that lead to a pose.
bool turns_a_corner(const SweepRecord& sweep, std::size_t pose) {
  if (pose < 2) return true;  // its start
  const double from = sweep.poses[pose - 2].control_deg, to = sweep.poses[pose].control_deg;
  return std::ranges::any_of(sweep.sweep.through, [&](const Waypoint& point) {
    return point.control_deg > from && point.control_deg < to;
  });
}

/// Whether the rig jumps or moves unusually fast between a pose and the one before it, or next to
/// it.
bool geometry_explains(const SweepRecord& sweep, std::size_t pose, const JudgeContext& context) {
  const double intervals = static_cast<double>(sweep.poses.size() - 1);
  const double from = (static_cast<double>(pose) - 2.0) / intervals;
  const double to = (static_cast<double>(pose) + 1.0) / intervals;
  const auto near = [&](const Jump& jump) { return jump.t >= from && jump.t <= to; };
  if (!sweep.flips.certified || std::ranges::any_of(sweep.flips.jumps, near)) return true;
  const std::vector<double>& gain = sweep.flips.interval_gain;
  const std::size_t first = pose >= 2 ? pose - 2 : 0, end = std::min(pose + 1, gain.size());
  return std::any_of(gain.begin() + static_cast<std::ptrdiff_t>(std::min(first, end)),
                     gain.begin() + static_cast<std::ptrdiff_t>(end),
                     [&](double g) { return g > context.limits.of("BB002").value; });
}

/// Whether joints beside the chain, which a live rig moves by itself, move the skin as suddenly as
/// the picture does: an arm that starts to bend because its hand stays behind.
bool limbs_explain(const Stage& stage, const RigRecord& rig, const SweepRecord& sweep,
                   std::size_t pose, double pixels, double pixel) {
  if (pose < 2 || external_rig(*rig.system) == nullptr) return false;
  const auto blended = [&](std::size_t p) {
    const PosedCharacter posed = stage.pose(*rig.system, sweep.poses[p].control);
    return skin::skin(stage.character(), posed.world_from_node).position;
  };
  const std::vector<glm::vec3> a = blended(pose - 2), b = blended(pose - 1), c = blended(pose);
  float most = 0.0f;
  for (std::size_t v = 0; v < c.size(); ++v)
    most = std::max(most, glm::length(a[v] - 2.0f * b[v] + c[v]));
  return most > 0.5 * pixels * pixel;
}

/// Whether the rig's own surface is known to jump there (BB037).
bool surface_explains(const RigRecord& rig, const SweepRecord& sweep, std::size_t pose,
                      const std::vector<Finding>& findings) {
  const double a = sweep.poses[pose >= 2 ? pose - 2 : 0].control_deg;
  const double b = sweep.poses[std::min(pose + 1, sweep.poses.size() - 1)].control_deg;
  return std::ranges::any_of(findings, [&](const Finding& finding) {
    return finding.code == "BB037" && sweep_of(rig, finding) == &sweep &&
           finding.control_deg >= std::min(a, b) && finding.control_deg <= std::max(a, b);
  });
}

}  // namespace

ImagePass::ImagePass(PhotographerPool& cameras, std::string character, Ledger& ledger)
    : stage_(cameras.stage()),
      cameras_(cameras),
      character_(std::move(character)),
      ledger_(ledger) {}

PoseViews ImagePass::views(Photographer& camera, const RigRecord& rig,
                           const PoseDegrees& pose) const {
  return take_views(camera, stage_.pose(*rig.system, controls_at(*rig.system, pose, rig.mapping)));
}

ImageWitness ImagePass::witness_flip(Photographer& camera, const RigRecord& rig,
                                     const SweepRecord& sweep, const Finding& finding) const {
  const auto posed = [&](const char* side) {
    const PoseDegrees pose = sweep.sweep.pose_at(finding.geometry.at(side));
    return stage_.pose(*rig.system, controls_at(*rig.system, pose, rig.mapping));
  };
  const PosedCharacter before = posed("before_deg"), after = posed("after_deg");
  ImageWitness witness =
      witness_of(motion(take_views(camera, after, &before)), "motion_px", kVisibleMotionPx);
  witness.note = std::string("between the frames on both sides of the ") +
                 (finding.code == "BB037" ? "jump" : "flip") +
                 ", which a continuous rig shows alike";
  return witness;
}

std::optional<PosedCharacter> ImagePass::with_proxy_weights(const RigRecord& rig,
                                                            const PoseDegrees& pose) {
  std::call_once(proxy_made_, [&] {
    const auto weights =
        proxy_weights(stage_.character(), stage_.anatomy(), stage_.driver(), stage_.rest());
    if (weights) {
      proxy_ = stage_.character();
      proxy_->influences = *weights;
    }
  });
  if (!proxy_) return std::nullopt;
  PosedCharacter posed = stage_.pose(*rig.system, controls_at(*rig.system, pose, rig.mapping));
  posed.mesh = skin::skin(*proxy_, posed.world_from_node, skin::SkinningMethod::linear);
  return posed;
}

/// Against the ideal bend of the pose; where the rig is that bend itself, against clean weights,
/// which is what such a finding is about. Never against itself.
ImageWitness ImagePass::witness_kink(Photographer& camera, const RigRecord& rig,
                                     const PoseDegrees& pose, const Finding& finding) {
  ImageWitness none;
  if (pose.hip != 0.0) {
    none.note = "not applicable: with a tipped hip the ideal bend has another pose in the cameras";
    return none;
  }
  const IdealBend ideal(pose);
  std::optional<PosedCharacter> clean;
  std::string against = "the spine 'even' in the same pose";
  if (rig_text(rig.plan.spec) != rig_text(ideal.spec)) {
    const std::unique_ptr<solver::SpineSystem> even = stage_.build(ideal.spec);
    clean = stage_.pose(*even, controls_at(*even, ideal.pose, rig.mapping));
  } else if (finding.owner == Owner::weights) {
    clean = with_proxy_weights(rig, pose);
    against = "clean proxy weights in the same pose";
  }
  if (!clean) {
    none.note =
        "not applicable: the rig is the ideal bend itself, and no cleaner weights are known";
    return none;
  }
  const PoseViews here = views(camera, rig, pose);
  const PoseViews there = take_views(camera, *clean);
  // A bend shows from the side; a side bend or a twist in whichever camera sees it best.
  const double bend = std::max(pose.extension, pose.flexion);
  const bool sagittal = bend > std::max(std::abs(pose.side), std::abs(pose.twist));
  ImageReading reading = tilt_jump(here, there, sagittal ? "profile" : "");
  if (sagittal && std::isnan(reading.value)) reading = tilt_jump(here, there);
  ImageWitness witness = witness_of(reading, "tilt_jump_deg", kVisibleTiltDeg);
  witness.note = "the sharpest change of the torso's tilt against " + against;
  return witness;
}

ImageWitness ImagePass::witness_arms(Photographer& camera, const RigRecord& rig,
                                     const PoseDegrees& pose) const {
  const solver::SpinePose posed = rig.system->solve(controls_at(*rig.system, pose, rig.mapping));
  if (moves_alike(posed.arms, posed.chest)) {
    ImageWitness none;
    none.note = "not applicable: the rig carries the arms with the chest exactly";
    return none;
  }
  const PoseViews here = take_views(camera, pose_with_arms(stage_, *rig.system, posed, posed.arms));
  const PoseViews there =
      take_views(camera, pose_with_arms(stage_, *rig.system, posed, posed.chest));
  ImageWitness witness = witness_of(arm_shift(here, there), "arm_shift_px", kVisibleArmPx);
  witness.note = witness.measured
                     ? "centre or 95 % outline distance of an arm's matte, carried by the rig's "
                       "own arm parent, from where the chest control would carry it"
                     : "no camera sees an arm";
  return witness;
}

ImageWitness ImagePass::witness_slices(Photographer& camera, const RigRecord& rig,
                                       const PoseDegrees& pose) const {
  const std::vector<double> control = controls_at(*rig.system, pose, rig.mapping);
  const PoseViews here = take_views(camera, stage_.pose(*rig.system, control));
  const PoseViews there =
      take_views(camera, stage_.pose(*rig.system, control, skin::SkinningMethod::dual_quaternion));
  ImageWitness witness = witness_of(narrowing(here, there), "narrowing_percent", kVisibleNarrowing);
  witness.note = "how much narrower the torso is than with dual quaternions on the same spine";
  return witness;
}

ImageWitness ImagePass::witness(Photographer& camera, const RigRecord& rig,
                                const SweepRecord& sweep, const Finding& finding) {
  const PoseDegrees pose = sweep.sweep.pose_at(finding.control_deg);
  switch (check_of(finding).pictures) {
    case Witness::jump:
      return witness_flip(camera, rig, sweep, finding);
    case Witness::kink:
      return witness_kink(camera, rig, pose, finding);
    case Witness::arms:
      return witness_arms(camera, rig, pose);
    case Witness::slices:
      return witness_slices(camera, rig, pose);
    case Witness::none:
      break;
  }
  ImageWitness none;
  none.note = "no picture metric looks at this";
  return none;
}

const ImageSteps& ImagePass::steps_of(const RigRecord& rig, const SweepRecord& sweep) const {
  return steps_.at(&rig)[static_cast<std::size_t>(&sweep - rig.sweeps.data())];
}

/// What a flip is to be compared with: a whole step of the same sweep.
void ImagePass::add_usual_step(const RigRecord& rig, const SweepRecord& sweep,
                               Finding& finding) const {
  std::vector<double> changes = steps_of(rig, sweep).change;
  if (changes.empty()) return;
  const double usual = upper_median(changes);
  finding.image.note +=
      "; a whole step of the sweep changes " + number_text(usual, 2) + " deg at the median";
}

ImageSteps ImagePass::steps_between(Photographer& camera, const RigRecord& rig,
                                    const SweepRecord& sweep, std::size_t first, std::size_t count,
                                    std::optional<Look>& before, Progress& progress) const {
  const auto posed = [&](std::size_t p) {
    return stage_.pose(*rig.system, sweep.poses[p].control);
  };
  // The pictures share no surface: nothing was compared, so no change is reported.
  const auto seen = [](const ImageReading& r) { return std::isnan(r.value) ? 0.0 : r.value; };
  // A step needs the pose before, and its motion the one before that.
  if (!before && first > 0) {
    std::optional<PosedCharacter> earlier;
    if (first > 1) earlier = posed(first - 2);
    before.emplace(posed(first - 1));
    before->views = take_views(camera, before->posed, earlier ? &*earlier : nullptr);
  }
  ImageSteps steps;
  for (std::size_t p = first; p < first + count; ++p) {
    poll_interrupt();
    Look now(posed(p));
    now.views = take_views(camera, now.posed, before ? &before->posed : nullptr);
    steps.change.push_back(before ? seen(normal_change(before->views, now.views)) : 0.0);
    steps.step.push_back(before ? seen(outline_shift(before->views, now.views)) : 0.0);
    steps.pop.push_back(p > 1 ? seen(motion_change(before->views, now.views)) : 0.0);
    before.emplace(std::move(now));
    progress.step();
  }
  return steps;
}

void ImagePass::add_units(const RigRecord& rig, std::vector<Unit>& units) {
  for (const SweepRecord& sweep : rig.sweeps) {
    if (!sweep.sweep.watched) continue;
    for (std::size_t first = 0; first < sweep.poses.size(); first += kPosesOfUnit) {
      Unit unit;
      unit.rig = &rig;
      unit.sweep = &sweep;
      unit.first = first;
      unit.count = std::min(kPosesOfUnit, sweep.poses.size() - first);
      unit.name = unit_name("image", character_, rig, sweep.sweep.name, first);
      unit.own = ledger_.makes(item_++);
      units.push_back(std::move(unit));
    }
  }
}

/// Units that follow each other. What the pose before one shows is known where that was looked at
/// just now, and looked at once more where it was not.
void ImagePass::look_at_units(std::span<Unit> units, Progress& progress) {
  std::optional<PhotographerPool::Loan> camera;
  std::optional<Look> before;  // at the pose before the next unit
  for (Unit& unit : units) {
    if (unit.first == 0) before.reset();
    if (const auto found = ledger_.find(unit.name)) {
      unit.steps = unpack_steps(*found);
      before.reset();
      progress.step(unit.count);
    } else if (unit.own) {
      if (!camera) camera.emplace(cameras_);
      unit.steps =
          steps_between(**camera, *unit.rig, *unit.sweep, unit.first, unit.count, before, progress);
      ledger_.keep(unit.name, pack_steps(unit.steps));
    } else {
      if (ledger_.assembles()) ledger_.miss(unit.name);
      before.reset();
    }
  }
}

void ImagePass::find_witness(const RigRecord& rig, const SweepRecord& sweep, std::size_t number,
                             Finding& finding) {
  poll_interrupt();
  // Every shard needs the witnesses: pictures are taken by the camera that sees most.
  const std::string unit = unit_name("witness", character_, rig, sweep.sweep.name, number);
  if (const auto found = ledger_.find(unit)) {
    finding.image = unpack_witness(*found);
  } else if (ledger_.mode() == Ledger::Mode::merge) {
    ledger_.miss(unit);
  } else {
    const PhotographerPool::Loan camera(cameras_);
    finding.image = witness(*camera, rig, sweep, finding);
    ledger_.keep(unit, pack_witness(finding.image));
  }
}

void ImagePass::look(std::span<const RigRecord> rigs, std::span<std::vector<Finding>> findings,
                     Progress& progress) {
  std::vector<Unit> units;
  for (const RigRecord& rig : rigs) add_units(rig, units);
  SideBySide work;
  const SideBySide::Group all = work.group();
  // A piece of many units looks at few poses twice: long pieces first, and at the end short ones,
  // so that all threads end at the same time.
  constexpr std::size_t kPiecesOfThread = 3;
  const auto threads = static_cast<std::size_t>(oneapi::tbb::this_task_arena::max_concurrency());
  for (std::size_t first = 0; first < units.size();) {
    const std::size_t left = units.size() - first;
    const std::size_t count =
        threads == 1 ? left : std::max<std::size_t>(1, left / (threads * kPiecesOfThread));
    work.add(all, [this, piece = std::span(units).subspan(first, count), &progress] {
      look_at_units(piece, progress);
    });
    first += count;
  }
  struct Question {
    const RigRecord* rig;
    const SweepRecord* sweep;
    Finding* finding;
  };
  std::vector<Question> questions;
  for (std::size_t r = 0; r < rigs.size(); ++r) {
    const std::vector<bool> shown = worst_of_each_code(findings[r]);
    for (const SweepRecord& sweep : rigs[r].sweeps) {
      for (std::size_t i = 0; i < findings[r].size(); ++i) {
        Finding& finding = findings[r][i];
        if (sweep_of(rigs[r], finding) != &sweep) continue;
        if (!shown[i]) {
          finding.image.note = "not looked at: worse ones of this check were";
          continue;
        }
        questions.push_back({&rigs[r], &sweep, &finding});
        work.add(all, [this, &rig = rigs[r], &sweep, i, &finding] {
          find_witness(rig, sweep, i, finding);
        });
      }
    }
  }
  work.run();
  for (const RigRecord& rig : rigs) steps_[&rig].assign(rig.sweeps.size(), {});
  for (const Unit& unit : units) {
    ImageSteps& whole =
        steps_[unit.rig][static_cast<std::size_t>(unit.sweep - unit.rig->sweeps.data())];
    for (auto part : {&ImageSteps::change, &ImageSteps::step, &ImageSteps::pop})
      std::ranges::copy(unit.steps.*part, std::back_inserter(whole.*part));
  }
  for (const Question& question : questions)
    if (question.finding->code == "BB001")
      add_usual_step(*question.rig, *question.sweep, *question.finding);
}

std::vector<Finding> ImagePass::contradictions(const RigRecord& rig,
                                               const std::vector<Finding>& findings,
                                               const JudgeContext& context) const {
  std::vector<Finding> out;
  for (const SweepRecord& sweep : rig.sweeps) {
    const std::vector<double>& change = steps_of(rig, sweep).pop;
    if (change.size() != sweep.poses.size()) continue;  // a shard saw its share
    const std::vector<double> score = pop_scores(change);
    for (std::size_t p = 1; p < score.size(); ++p) {
      if (!(score[p] > kPopScore) || turns_a_corner(sweep, p) ||
          geometry_explains(sweep, p, context) || surface_explains(rig, sweep, p, findings) ||
          limbs_explain(stage_, rig, sweep, p, change[p], view_pixel(cameras_.box())))
        continue;
      const PoseRecord& pose = sweep.poses[p];
      out.push_back(start_finding(rig, context, sweep, "BB070", pose.body, pose.control_deg));
      out.back().at.pose = static_cast<int>(p);
      out.back().detail = "the picture's motion changes by " + number_text(change[p], 2) +
                          " px at once, and no joint's does";
      out.back().geometry["picture_only"] = 1.0;
    }
  }
  for (const Finding& finding : findings) {
    if (!finding.image.measured || finding.image.visible) continue;
    if (!(seen_size(finding) > check_of(finding).always_seen)) continue;
    const SweepRecord* sweep = sweep_of(rig, finding);
    if (sweep == nullptr) continue;
    out.push_back(start_finding(rig, context, *sweep, "BB070",
                                sweep->sweep.pose_at(finding.control_deg), finding.control_deg));
    out.back().detail = finding.code + " measures " + number_text(finding.value, 2) + " " +
                        finding.unit + " and no picture shows it";
  }
  for (Finding& finding : out) {
    finding.value = 1.0;
    finding.verdict = Verdict::stress;  // ours to explain: it does not decide about the rig
  }
  return out;
}

void ImagePass::add_series(const RigRecord& rig, RigResult& result) const {
  for (std::size_t s = 0; s < result.sweeps.size(); ++s) {
    if (!rig.sweeps[s].sweep.watched) continue;
    SweepSeries& sweep = result.sweeps[s];
    const ImageSteps& steps = steps_of(rig, rig.sweeps[s]);
    sweep.metric["image_change"] = steps.change;
    sweep.metric["silhouette_step"] = steps.step;
    sweep.metric["motion_change"] = steps.pop;
    sweep.metric_unit["image_change"] = "deg";
    sweep.metric_unit["silhouette_step"] = "px";
    sweep.metric_unit["motion_change"] = "px";
  }
}

}  // namespace backbend::validate
