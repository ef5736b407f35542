#include "validate/repair/repair_sheet.h"

#include <algorithm>

#include "render/image/png.h"
#include "render/review/sheet.h"
#include "skin/weights/weight_graph.h"
#include "validate/camera/photographer.h"
#include "validate/evidence/finding_view.h"
#include "validate/evidence/heat_picture.h"
#include "validate/evidence/metric_heat.h"
#include "validate/measure/measure.h"
#include "validate/sweeps/sweep_named.h"
#include "validate/verdicts/checks.h"

namespace backbend::validate {
namespace {

constexpr int kWidth = 400, kHeight = 400, kSamples = 16, kColumns = 3;
constexpr float kAllChanged = 100.0f;  // % of a vertex's weight

/// One side, in the pose that is shown.
struct Side {
  Side(const skin::Character& character, const skin::Anatomy& anatomy, const PoseDegrees& pose)
      : stage(character, anatomy),
        system(stage.build({"even", {}})),
        control(controls_at(*system, pose, solver::Mapping::chest)),
        posed(stage.pose(*system, control)) {}

  VertexHeat heat_of(const Finding& finding, double twist) const {
    const BodyMetrics body(stage.character(), stage.anatomy(), stage.driver());
    return metric_heat(stage, body, {*system, control, posed, twist}, finding);
  }

  Stage stage;
  std::unique_ptr<solver::SpineSystem> system;
  std::vector<double> control;
  PosedCharacter posed;
};

/// The worst finding at a pose of a sweep; nullptr: none has one.
const Finding* shown_finding(const RepairedBody& body) {
  const auto found = std::ranges::find_if(
      body.findings, [](const Finding& finding) { return finding.at.sweep >= 0; });
  return found == body.findings.end() ? nullptr : &*found;
}

PoseDegrees pose_of(const RepairedBody& body, const Finding* finding) {
  if (finding == nullptr) return {body.envelope.extension};
  return bundled_sweeps(body.envelope)[static_cast<std::size_t>(finding->at.sweep)].pose_at(
      finding->control_deg);
}

VertexHeat weight_changed(const skin::Character& before, const skin::Character& after) {
  VertexHeat heat{"weight changed, %", "%", 0.0f, kAllChanged, {}};
  for (std::size_t v = 0; v < after.vertex_count(); ++v)
    heat.value.push_back(
        kAllChanged * static_cast<float>(skin::share_moved(skin::shares_of(before.influences[v]),
                                                           skin::shares_of(after.influences[v]))));
  return heat;
}

}  // namespace

std::vector<std::uint8_t> repair_sheet(const RepairedBody& body, Progress& progress) {
  const Finding* finding = shown_finding(body);
  const PoseDegrees pose = pose_of(body, finding);
  const Side before(body.before, body.anatomy, pose), after(body.after, body.anatomy, pose);
  render::Bounds box = before.stage.bounds(before.posed.mesh);
  box.add(after.stage.bounds(after.posed.mesh));
  Photographer old_body(before.stage, box), new_body(after.stage, box);
  render::Settings settings;
  settings.width = kWidth;
  settings.height = kHeight;
  settings.samples = kSamples;
  const FindingView view = view_of(pose, finding ? *finding : Finding());
  const render::Camera camera =
      render::view_camera(view.camera, box, view.facing(old_body.facing()), 1.0);
  std::vector<render::SheetCell> cells;
  progress.start("pictures", 5);
  const auto add = [&](render::Picture picture, const std::string& label) {
    cells.push_back({std::move(picture), label, false});
    progress.step();
    poll_interrupt();
  };
  const auto clay = [&](Photographer& photographer, const Side& side) {
    photographer.pose(side.posed);
    return render::picture_from(photographer.shoot(camera, settings));
  };
  const auto heated = [&](Photographer& photographer, const Side& side, const VertexHeat& heat) {
    return heat_picture(photographer, settings, side.posed, heat, camera, std::nullopt);
  };
  add(clay(old_body, before), "before: " + pose.text());
  add(clay(new_body, after), "after");
  add(heated(new_body, after, weight_changed(body.before, body.after)), "what was changed");
  if (finding != nullptr) {
    VertexHeat was = before.heat_of(*finding, pose.radians().twist);
    VertexHeat is = after.heat_of(*finding, pose.radians().twist);
    if (!was.value.empty() && !is.value.empty()) {
      was.high = is.high = std::max(was.high, is.high);
      const std::string name(find_check(finding->code)->name);
      add(heated(old_body, before, was), finding->code + " " + name + " before");
      add(heated(new_body, after, is), finding->code + " " + name + " after");
    }
  }
  progress.finish();
  return render::encode_png(render::contact_sheet(cells, kColumns, ""));
}

}  // namespace backbend::validate
