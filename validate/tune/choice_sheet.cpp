#include "validate/tune/choice_sheet.h"

#include "render/image/picture.h"
#include "render/image/png.h"
#include "render/review/sheet.h"
#include "validate/camera/photographer.h"
#include "validate/evidence/finding_view.h"
#include "validate/measure/measure.h"

namespace backbend::validate {
namespace {

constexpr int kSheetWidth = 320, kSheetHeight = 320, kSamples = 16;

}  // namespace

std::vector<std::uint8_t> choice_sheet(const Stage& stage, const std::vector<SheetRig>& rigs,
                                       const std::vector<Direction>& poses, solver::Mapping mapping,
                                       Progress& progress) {
  std::vector<PosedCharacter> posed;
  render::Bounds box = stage.bounds(stage.rest());
  for (const Direction& pose : poses)
    for (const SheetRig& rig : rigs) {
      const auto system = stage.build(rig.spec);
      posed.push_back(stage.pose(*system, controls_at(*system, pose.end, mapping)));
      box.add(stage.bounds(posed.back().mesh));
    }
  Photographer photographer(stage, box);
  render::Settings settings;
  settings.width = kSheetWidth;
  settings.height = kSheetHeight;
  settings.samples = kSamples;
  std::vector<render::SheetCell> cells;
  progress.start("pictures", posed.size());
  for (std::size_t i = 0; i < posed.size(); ++i) {
    poll_interrupt();
    const Direction& pose = poses[i / rigs.size()];
    photographer.pose(posed[i]);
    const FindingView view = view_of(pose.end, {});
    cells.push_back({render::picture_from(photographer.shoot(view.camera, settings)),
                     rigs[i % rigs.size()].label + ": " + pose.name, false});
    progress.step();
  }
  progress.finish();
  return render::encode_png(render::contact_sheet(cells, static_cast<int>(rigs.size()), ""));
}

}  // namespace backbend::validate
