#include "validate/compare/worst_frames.h"

#include "render/image/png.h"
#include "validate/judge/judge.h"

namespace backbend::validate {
namespace {

std::string shoot(const ComparedSide& side, const PoseDegrees& pose, Photographer& photographer,
                  const render::Settings& settings, const OutputFolder& folder,
                  const std::string& name) {
  poll_interrupt();
  const PosedCharacter body =
      side.stage.pose(*side.rig.system, controls_at(*side.rig.system, pose, side.rig.mapping));
  photographer.pose(body);
  const auto view = render::view_names().front();
  folder.write(name, render::encode_png(render::picture_from(photographer.shoot(view, settings))));
  return name;
}

}  // namespace

void show_worst(Comparison& comparison, const ComparedSide& a, const ComparedSide& b,
                const render::Bounds& box, const PicturePlan& plan, const OutputFolder& folder,
                Progress& progress) {
  Photographer of_a(a.stage, box), of_b(b.stage, box);
  render::Settings settings;
  settings.width = plan.width;
  settings.height = plan.height;
  settings.samples = plan.samples;
  if (plan.enabled)
    progress.start("frames", 2 * (comparison.worst_of_a.size() + comparison.worst_of_b.size()));
  for (const bool against_a : {true, false}) {
    auto& poses = against_a ? comparison.worst_of_a : comparison.worst_of_b;
    for (std::size_t i = 0; i < poses.size(); ++i) {
      ComparedPose& pose = poses[i];
      const PoseDegrees degrees =
          a.rig.sweeps[static_cast<std::size_t>(pose.at.sweep)].sweep.pose_at(pose.control_deg);
      pose.a_command = command_for(a.rig, a.character, a.stage.chain(), degrees);
      pose.b_command = command_for(b.rig, b.character, b.stage.chain(), degrees);
      if (!plan.enabled) continue;
      const std::string name = std::string("compare/against_") + (against_a ? "a" : "b") + "_" +
                               std::to_string(i + 1) + "_" + pose.code;
      pose.a_path = shoot(a, degrees, of_a, settings, folder, name + "_a.png");
      progress.step();
      pose.b_path = shoot(b, degrees, of_b, settings, folder, name + "_b.png");
      progress.step();
    }
  }
}

}  // namespace backbend::validate
