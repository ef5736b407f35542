#include "validate/run/image_pass.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "render/cryptomatte.h"
#include "validate/farm/measure_job.h"
#include "validate/metrics/flip_image.h"
#include "validate/metrics/image.h"

namespace backbend::validate {
namespace {

/// Small enough for every pose of a night, large enough that a hand is some pixels wide.
constexpr int kWidth = 320, kHeight = 240;
constexpr std::array<std::string_view, 3> kViews = {"profile", "front", "three_quarter"};
/// A pixel whose normal turned by more is seen to change (research/reports.md 1.2, first step).
constexpr float kVisibleTurnDeg = 5.0f;
/// Fewer changed pixels than this are noise of the outline.
constexpr double kVisiblePixels = 20.0;
/// Mean change of the normal layer that two pictures of one pose may show
/// (research/reports.md 1.2).
constexpr double kSamePoseDeg = 0.05;
/// Outlines are exact to about half a pixel on either side.
constexpr double kVisibleOutlinePx = 1.0;
/// Curvature that a picture of a clean spine in the same pose does not show.
constexpr double kVisibleCurvatureRatio = 1.25;

render::Settings primary_settings() {
  render::Settings settings;
  settings.width = kWidth;
  settings.height = kHeight;
  settings.samples = 1;
  settings.mode = render::Mode::primary;
  settings.ground = false;
  settings.position_and_albedo = true;
  return settings;
}

ImageView view_of(const render::Frame& frame, std::string_view first_channel) {
  const render::Layer* layer = frame.find(first_channel);
  if (layer == nullptr) return {};
  return {frame.width, frame.height, static_cast<int>(layer->names.size()), layer->data};
}

Mask figure(const render::Frame& frame) { return silhouette(view_of(frame, "R"), 3); }

/// Pixels that show either arm, by their matte.
Mask arms(const render::Frame& frame) {
  const ImageView matte = view_of(frame, "CryptoObject00.r");
  const float left = render::cryptomatte_id("arm_L"), right = render::cryptomatte_id("arm_R");
  Mask mask{frame.width, frame.height, std::vector<std::uint8_t>(matte.pixel_count(), 0)};
  for (std::size_t i = 0; i < mask.inside.size(); ++i) {
    const float id = matte.data[i * static_cast<std::size_t>(matte.channels)];
    mask.inside[i] = id == left || id == right ? 1 : 0;
  }
  return mask;
}

double mean_turn(const render::Frame& a, const render::Frame& b) {
  const double mean = normal_difference(view_of(a, "N.X"), view_of(b, "N.X")).statistics.mean;
  return std::isnan(mean) ? 0.0 : mean;  // no pixel shows a surface in both: nothing was compared
}

double changed_pixels(const render::Frame& a, const render::Frame& b) {
  const NormalDifference difference = normal_difference(view_of(a, "N.X"), view_of(b, "N.X"));
  return static_cast<double>(std::count_if(difference.map.begin(), difference.map.end(),
                                           [](float turn) { return turn > kVisibleTurnDeg; }));
}

double median_of(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

double curvature(const render::Frame& frame) {
  const double pixel_angle = 2.0 * std::atan(18.0 / 50.0) / kWidth;  // 36 mm film behind 50 mm
  const ImageView object = view_of(frame, "CryptoAsset00.r");
  std::vector<float> number(object.pixel_count());
  for (std::size_t i = 0; i < number.size(); ++i) {
    number[i] = object.data[i * static_cast<std::size_t>(object.channels)] != 0.0f ? 1.0f : 0.0f;
  }
  const ImageView mask{frame.width, frame.height, 1, number};
  return surface_curvature(view_of(frame, "P.X"), view_of(frame, "N.X"), mask, view_of(frame, "Z"),
                           pixel_angle)
      .statistics.p999;
}

}  // namespace

struct ImagePass::View {
  std::string_view name;
  render::Frame frame;
};

ImagePass::ImagePass(const Stage& stage, const render::Bounds& box, std::string character,
                     Ledger& ledger)
    : stage_(stage), photographer_(stage, box), character_(std::move(character)), ledger_(ledger) {}

std::vector<ImagePass::View> ImagePass::shoot(const PosedCharacter& posed) {
  static const render::Settings settings = primary_settings();
  photographer_.pose(posed);
  std::vector<View> views;
  for (const std::string_view name : kViews)
    views.push_back({name, photographer_.shoot(name, settings)});
  return views;
}

std::vector<ImagePass::View> ImagePass::shoot(const RigRecord& rig, const PoseRecord& pose) {
  return shoot(stage_.pose(*rig.system, pose.control));
}

ImageWitness ImagePass::witness_flip(const RigRecord& rig, const SweepRecord& sweep,
                                     const Finding& finding) {
  const auto at = [&](const char* key) {
    const PoseDegrees pose = sweep.sweep.pose_at(finding.geometry.at(key));
    return shoot(stage_.pose(*rig.system, controls_at(*rig.system, pose, rig.mapping)));
  };
  const std::vector<View> before = at("before_deg"), after = at("after_deg");
  ImageWitness witness;
  witness.measured = true;
  witness.metric = "normal_change_deg";
  witness.threshold = kSamePoseDeg;
  for (std::size_t i = 0; i < before.size(); ++i) {
    const double turn = mean_turn(before[i].frame, after[i].frame);
    if (i > 0 && turn <= witness.value) continue;
    witness.value = turn;
    witness.camera = before[i].name;
    witness.pixels = changed_pixels(before[i].frame, after[i].frame);
  }
  witness.visible = witness.value > witness.threshold && witness.pixels >= kVisiblePixels;
  witness.note = "between the frames on both sides of the flip, which a continuous rig shows alike";
  return witness;
}

ImageWitness ImagePass::witness_kink(const RigRecord& rig, const SweepRecord& sweep,
                                     const Finding& finding) {
  const PoseDegrees pose = sweep.sweep.pose_at(finding.control_deg);
  const std::unique_ptr<solver::SpineSystem> clean = stage_.build({"even", {}});
  const std::vector<View> here =
      shoot(stage_.pose(*rig.system, controls_at(*rig.system, pose, rig.mapping)));
  const std::vector<View> there =
      shoot(stage_.pose(*clean, controls_at(*clean, pose, rig.mapping)));
  ImageWitness witness;
  witness.measured = true;
  witness.metric = "curvature_ratio";
  witness.threshold = kVisibleCurvatureRatio;
  for (std::size_t i = 0; i < here.size(); ++i) {
    const double ratio = curvature(here[i].frame) / curvature(there[i].frame);
    if (!(ratio > witness.value)) continue;
    witness.value = ratio;
    witness.camera = here[i].name;
    witness.pixels = changed_pixels(here[i].frame, there[i].frame);
  }
  witness.visible = witness.value > witness.threshold;
  witness.note = "sharpest surface curvature, over that of the spine 'even' in the same pose";
  return witness;
}

ImageWitness ImagePass::witness_arms(const RigRecord& rig, const SweepRecord& sweep,
                                     const Finding& finding) {
  const PoseDegrees pose = sweep.sweep.pose_at(finding.control_deg);
  PosedCharacter posed = stage_.pose(*rig.system, controls_at(*rig.system, pose, rig.mapping));
  const std::vector<View> here = shoot(posed);
  solver::SpinePose carried = posed.spine;
  carried.arms = carried.chest;
  const std::vector<View> there = shoot(stage_.pose(*rig.system, std::move(carried)));
  ImageWitness witness;
  witness.metric = "arm_outline_px";
  witness.threshold = kVisibleOutlinePx;
  for (std::size_t i = 0; i < here.size(); ++i) {
    const Mask a = arms(here[i].frame), b = arms(there[i].frame);
    const double distance = outline_distance(a, b).most;
    if (std::isnan(distance)) continue;  // no arm in this view
    if (witness.measured && distance <= witness.value) continue;
    witness.measured = true;
    witness.value = distance;
    witness.camera = here[i].name;
    witness.pixels = changed_pixels(here[i].frame, there[i].frame);
  }
  witness.visible = witness.measured && witness.value > witness.threshold;
  witness.note =
      witness.measured
          ? "95 % outline distance of the arm mattes from arms that the chest control carries"
          : "no camera sees an arm";
  return witness;
}

ImageWitness ImagePass::witness(const RigRecord& rig, const SweepRecord& sweep,
                                const Finding& finding) {
  if (finding.code == "BB001") return witness_flip(rig, sweep, finding);
  if (finding.code == "BB010" || finding.code == "BB011") return witness_kink(rig, sweep, finding);
  if (finding.code == "BB020" || finding.code == "BB021") return witness_arms(rig, sweep, finding);
  ImageWitness none;
  none.note = "no picture metric looks at this";
  return none;
}

/// What a flip is to be compared with: a whole step of the same sweep.
void ImagePass::add_usual_step(const SweepRecord& sweep, Finding& finding) const {
  const auto steps = series_.find(sweep.sweep.name);
  const double usual = steps == series_.end() ? 0.0 : median_of(steps->second.at("image_change"));
  finding.image.note +=
      "; a whole step of the sweep changes " + number_text(usual, 2) + " deg at the median";
}

ImageSteps ImagePass::steps_between(const RigRecord& rig, const SweepRecord& sweep,
                                    std::size_t first, std::size_t count, std::vector<View>& before,
                                    Progress& progress) {
  if (before.empty() && first > 0) before = shoot(rig, sweep.poses[first - 1]);
  ImageSteps steps;
  for (std::size_t p = first; p < first + count; ++p) {
    poll_interrupt();
    std::vector<View> now = shoot(rig, sweep.poses[p]);
    double worst_turn = 0.0, worst_step = 0.0;
    for (std::size_t i = 0; i < before.size(); ++i) {
      worst_turn = std::max(worst_turn, mean_turn(before[i].frame, now[i].frame));
      const double distance = outline_distance(figure(before[i].frame), figure(now[i].frame)).most;
      if (distance > worst_step) worst_step = distance;
    }
    steps.change.push_back(worst_turn);
    steps.step.push_back(worst_step);
    before = std::move(now);
    progress.step();
  }
  return steps;
}

void ImagePass::look_at_sweep(const RigRecord& rig, const SweepRecord& sweep, Progress& progress) {
  std::vector<double>& change = series_[sweep.sweep.name]["image_change"];
  std::vector<double>& step = series_[sweep.sweep.name]["silhouette_step"];
  std::vector<View> before;  // of the pose before the next unit, or none
  for (std::size_t first = 0; first < sweep.poses.size(); first += kPosesOfUnit) {
    const std::size_t count = std::min(kPosesOfUnit, sweep.poses.size() - first);
    const std::string unit = unit_name("image", character_, rig, sweep.sweep.name, first);
    const bool own = ledger_.makes(item_++);
    ImageSteps steps;
    if (const auto found = ledger_.find(unit)) {
      steps = unpack_steps(*found);
      before.clear();
      progress.step(count);
    } else if (own) {
      steps = steps_between(rig, sweep, first, count, before, progress);
      ledger_.keep(unit, pack_steps(steps));
    } else {
      if (ledger_.assembles()) ledger_.miss(unit);
      before.clear();
    }
    change.insert(change.end(), steps.change.begin(), steps.change.end());
    step.insert(step.end(), steps.step.begin(), steps.step.end());
  }
}

void ImagePass::look(const RigRecord& rig, std::vector<Finding>& findings, Progress& progress) {
  series_.clear();
  for (const SweepRecord& sweep : rig.sweeps) {
    look_at_sweep(rig, sweep, progress);
    for (std::size_t i = 0; i < findings.size(); ++i) {
      Finding& finding = findings[i];
      if (finding.sweep != sweep.sweep.name) continue;
      poll_interrupt();
      // Every shard needs the witnesses: pictures are taken by the camera that sees most.
      const std::string unit = unit_name("witness", character_, rig, sweep.sweep.name, i);
      if (const auto found = ledger_.find(unit)) {
        finding.image = unpack_witness(*found);
      } else if (ledger_.mode() == Ledger::Mode::merge) {
        ledger_.miss(unit);
      } else {
        finding.image = witness(rig, sweep, finding);
        ledger_.keep(unit, pack_witness(finding.image));
      }
      if (finding.code == "BB001") add_usual_step(sweep, finding);
    }
  }
}

void ImagePass::add_series(RigResult& result) const {
  for (SweepSeries& sweep : result.sweeps) {
    const auto found = series_.find(sweep.sweep);
    if (found == series_.end()) continue;
    for (const auto& [name, values] : found->second) sweep.metric[name] = values;
    sweep.metric_unit["image_change"] = "deg";
    sweep.metric_unit["silhouette_step"] = "px";
  }
}

}  // namespace backbend::validate
