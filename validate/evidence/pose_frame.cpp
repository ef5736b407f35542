#include "validate/evidence/pose_frame.h"

#include "validate/tasks/progress.h"

namespace backbend::validate {

render::Bounds framing_box(const Stage& stage, const PosedCharacter& posed) {
  render::Bounds box = stage.bounds(stage.rest());
  box.add(stage.bounds(posed.mesh));
  return box;
}

render::Frame pose_frame(const Stage& stage, const PosedCharacter& posed, const std::string& view,
                         const render::Settings& settings, std::span<const float> heat,
                         std::span<const render::OverlayLine> controllers) {
  Photographer photographer(stage, framing_box(stage, posed));
  photographer.pose(posed, heat, nullptr, controllers);
  render::Frame frame = photographer.shoot(view, settings);
  poll_interrupt();
  return frame;
}

}  // namespace backbend::validate
