#include "validate/camera/photographer.h"

#include <algorithm>

#include "render/image/half_layers.h"
#include "validate/tasks/progress.h"
#include "validate/tasks/superseded.h"

namespace backbend::validate {
namespace {

constexpr glm::vec3 kBoneColor{0.95f, 0.55f, 0.1f};

/// The solved chain as lines, for x-ray pictures.
std::vector<render::OverlayLine> bone_lines(const solver::SpinePose& spine) {
  std::vector<render::OverlayLine> lines;
  for (std::size_t i = 1; i < spine.position.size(); ++i) {
    lines.push_back(
        {glm::vec3(spine.position[i - 1]), glm::vec3(spine.position[i]), kBoneColor, 3.0f});
  }
  return lines;
}

}  // namespace

std::vector<render::OverlayLine> controller_lines(
    const std::vector<solver::ControllerShape>& shapes) {
  static constexpr glm::vec3 kColors[] = {
      {0.0f, 0.25f, 0.75f}, {0.85f, 0.65f, 0.0f}, {0.75f, 0.1f, 0.35f}};
  std::vector<render::OverlayLine> lines;
  for (const solver::ControllerShape& shape : shapes) {
    for (const auto& line : shape.line)
      lines.push_back({glm::vec3(line[0]), glm::vec3(line[1]), kColors[shape.color], 2.0f});
  }
  return lines;
}

render::Settings scrubber_frame(render::Settings still) {
  constexpr int kWidth = 320, kHeight = 240, kSamples = 8;
  still.width = kWidth;
  still.height = kHeight;
  still.samples = std::min(kSamples, still.samples);
  still.least_samples = kSamples / 2;
  still.bounces = 1;
  still.mattes = false;
  return still;
}

render::Facing facing_of(const skin::Anatomy& anatomy) { return {anatomy.up, anatomy.forward}; }

Photographer::Photographer(const Stage& stage, const render::Bounds& box)
    : Photographer(stage, box, stage.topology()) {}

Photographer::Photographer(const Stage& stage, const render::Bounds& box,
                           std::shared_ptr<const render::MeshTopology> topology)
    : stage_(stage), box_(box), facing_(facing_of(stage.anatomy())), scene_(std::move(topology)) {}

void Photographer::pose(const PosedCharacter& posed, std::span<const float> heat,
                        const PosedCharacter* previous,
                        std::span<const render::OverlayLine> controllers) {
  bones_ = bone_lines(posed.spine);
  bones_.insert(bones_.end(), controllers.begin(), controllers.end());
  render::PoseGeometry geometry;
  geometry.position = posed.mesh.position;
  geometry.normal = posed.mesh.normal;
  geometry.heat = heat;
  geometry.overlay = bones_;
  if (previous != nullptr) geometry.previous_position = previous->mesh.position;
  scene_.set_pose(geometry);
}

render::Frame Photographer::shoot(std::string_view view, const render::Settings& settings) const {
  const double aspect = static_cast<double>(settings.width) / settings.height;
  return shoot(render::view_camera(view, box_, facing_, aspect), settings);
}

render::Frame Photographer::shoot(const render::Camera& camera,
                                  const render::Settings& settings) const {
  // What later looks at the frame in memory must see what a reader of its file sees.
  render::Settings stoppable = settings;
  stoppable.stop = stop_pending;
  render::Frame frame = scene_.render(camera, stoppable);
  poll_interrupt();  // an unfinished frame goes no further
  render::round_half_layers(frame);
  return frame;
}

}  // namespace backbend::validate
