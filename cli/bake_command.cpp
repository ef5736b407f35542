#include <cmath>
#include <cstdio>

#include "cli/commands.h"
#include "cli/external_options.h"
#include "cli/settings.h"
#include "cli/sweep_option.h"
#include "skin/gltf/glb_writer.h"
#include "skin/gltf/usd_writer.h"
#include "validate/camera/photographer.h"
#include "validate/evidence/usd_scene.h"
#include "validate/files/output_folder.h"
#include "validate/judge/confirmed.h"
#include "validate/measure/measure.h"
#include "validate/model/report_json.h"
#include "validate/stage/stage.h"
#include "validate/sweeps/suite.h"
#include "validate/tasks/progress.h"
#include "validate/text/escape.h"

namespace backbend::cli {
namespace {

namespace fs = std::filesystem;
using namespace backbend::validate;

struct BakeOptions {
  std::string character, rig = "even", sweep = "extension", mapping = "chest", output, usd, run;
  double frames_per_second = 24.0;
  skin::AnatomyHints hints;
  ExternalOptions external;
};

/// Usage errors that need no file to be read.
void check_options(const BakeOptions& options) {
  if (options.output.empty() && options.usd.empty())
    throw CLI::RequiredError("-o OUT.glb or --usd OUT.usda");
  if (!options.usd.empty() && fs::path(options.usd).extension() != ".usda")
    throw CLI::ValidationError("--usd: '" + options.usd + "': expected a name that ends in .usda");
  if (!options.run.empty() && options.usd.empty())
    throw CLI::ValidationError("--findings needs --usd, the only form that holds them");
}

/// A sweep as every form of file gets it: the nodes at each frame, the angles, and the box that
/// holds every pose.
struct Baked {
  skin::GlbAnimation animation;
  std::vector<double> control_deg;
  render::Bounds box;
};

Baked bake(const Stage& stage, const solver::SpineSystem& system, const Sweep& sweep,
           const BakeOptions& options) {
  Baked baked;
  baked.animation.name = options.rig + "_" + sweep.name;
  baked.box = render::bounds_of(stage.rest().position);
  for (std::size_t i = 0; i < sweep.pose_count(); ++i) {
    poll_interrupt();
    baked.animation.time.push_back(
        static_cast<float>(static_cast<double>(i) / options.frames_per_second));
    baked.control_deg.push_back(sweep.control_at(i));
    const auto control = controls_at(system, sweep.pose_at(baked.control_deg.back()),
                                     *find_mapping(options.mapping));
    PosedCharacter body = stage.pose(system, control);
    baked.box.add(render::bounds_of(body.mesh.position));
    baked.animation.world_from_node.push_back(std::move(body.world_from_node));
  }
  return baked;
}

/// USD knows two upward axes.
char up_axis(const Stage& stage) { return std::abs(stage.anatomy().up.z) > 0.7 ? 'Z' : 'Y'; }

skin::UsdScene scene_of(const Stage& stage, const Baked& baked, const Sweep& sweep,
                        const std::string& rig, const BakeOptions& options) {
  skin::UsdScene scene;
  scene.doc = visible("backbend bake: " + stage.character().name + ", rig " + rig + ", sweep " +
                      sweep.name + ", mapping " + options.mapping);
  scene.up = up_axis(stage);
  scene.frames_per_second = options.frames_per_second;
  scene.first_frame = kFirstFrame;
  scene.cameras = usd_cameras(baked.box, facing_of(stage.anatomy()));
  if (!options.run.empty()) {
    fs::path file(options.run);
    if (fs::is_directory(file)) file /= "report.json";
    scene.notes = usd_findings(
        parse_report(read_text(file), file.string()), file.string(),
        {stage.character().name, rig, options.mapping, sweep.name, baked.control_deg, kFirstFrame});
  }
  return scene;
}

int run_bake(const BakeOptions& options, const Common& common) {
  check_options(options);
  ConfirmedCharacter confirmed = load_confirmed(options.character, options.hints);
  const Stage stage(
      std::move(confirmed.character), confirmed.hints, DrivenChain::spine,
      confirmed.sidecar ? confirmed.sidecar->controls : std::vector<skin::SidecarControl>());
  const RigPlan rig = options.external.read_rig(options.rig);
  const auto system = stage.build(rig.spec);
  const Sweep sweep = sweep_option(options.sweep);
  const Baked baked = bake(stage, *system, sweep, options);
  // Everything is made before anything is written.
  std::vector<std::uint8_t> glb;
  skin::UsdText usd;
  if (!options.output.empty()) glb = skin::encode_glb(stage.character(), &baked.animation);
  if (!options.usd.empty())
    usd = skin::usd_text(stage.character(), baked.animation,
                         scene_of(stage, baked, sweep, rig.name, options));
  const auto wrote = [&](const fs::path& file) {
    if (!common.quiet)
      std::fprintf(stderr, "wrote %s: %zu frames\n", visible(file.string()).c_str(),
                   baked.control_deg.size());
  };
  if (const fs::path file(options.output); !glb.empty()) {
    OutputFolder(file.parent_path()).write(file.filename(), glb);
    wrote(file);
  }
  if (const fs::path file(options.usd); !usd.text.empty()) {
    OutputFolder(file.parent_path()).write(file.filename(), usd.text);
    wrote(file);
    if (usd.rounded_scales > 0 && !common.quiet)
      std::fprintf(stderr,
                   "note: %s: %zu scales are rounded to half precision, as UsdSkel stores them; "
                   "the worst by %s %%\n",
                   visible(file.string()).c_str(), usd.rounded_scales,
                   number_text(100.0 * usd.worst_scale_error, 4).c_str());
  }
  return 0;
}

}  // namespace

void add_bake(const Registry& registry) {
  auto options = std::make_shared<BakeOptions>();
  CLI::App* command =
      registry.add("bake", "write a rig's sweep as a skinned animation: .glb, or UsdSkel as .usda",
                   [options, &common = registry.common] { return run_bake(*options, common); });
  command
      ->add_option("character", options->character,
                   "character file: .glb, .gltf, .fbx, .dae, or a body description .toml")
      ->required();
  command->add_option("--rig", options->rig, kRigHelp)->type_name(kRigType)->configurable();
  options->external.add_to(command);
  command->add_option("--sweep", options->sweep, "sweep (backbend list sweeps) [extension]");
  command->add_option("--mapping", options->mapping, "chest or spread [chest]")
      ->check(CLI::IsMember({"chest", "spread"}))
      ->configurable();
  command->add_option("--fps", options->frames_per_second, "frames a second, 1 to 1000 [24]")
      ->check(CLI::Range(1.0, 1000.0))
      ->configurable();
  command->add_option("-o,--output", options->output, "the .glb to write");
  command->add_option("--usd", options->usd,
                      "the .usda to write: skeleton, skin, motion from frame 1001, cameras");
  command->add_option("--findings", options->run,
                      "with --usd: run folder or report.json whose findings of this rig on this "
                      "character go along as custom data");
  add_anatomy_options(command, options->hints);
}

}  // namespace backbend::cli
