#include <cstdio>

#include "cli/commands.h"
#include "cli/external_options.h"
#include "cli/settings.h"
#include "cli/sweep_option.h"
#include "skin/body.h"
#include "skin/body_proxy.h"
#include "skin/glb_writer.h"
#include "skin/gltf_reader.h"
#include "validate/files/data_folder.h"
#include "validate/files/import.h"
#include "validate/files/output_folder.h"
#include "validate/run/confirmed.h"
#include "validate/run/measure.h"
#include "validate/run/stage.h"
#include "validate/sweeps/suite.h"

namespace backbend::cli {

namespace fs = std::filesystem;
using namespace backbend::validate;

/// A description is built; any other file gets a proxy body around its skeleton.
skin::Character made_body(const fs::path& source, const skin::AnatomyHints& hints,
                          const skin::BodyOptions& options) {
  if (source.extension() == ".toml")
    return skin::make_body(skin::read_body_description(source), options);
  const skin::Character skeleton = skin::read_skeleton(load_document(source));
  return skin::make_proxy_body(skeleton, skin::find_anatomy(skeleton, hints), options);
}

void add_body(const Registry& registry) {
  struct Options {
    std::string source, output;
    int vertices = 0;
    skin::AnatomyHints hints;
  };
  auto options = std::make_shared<Options>();
  CLI::App* command = registry.add(
      "body",
      "make a character, .glb: a closed mesh with smooth weights, from a description or around a "
      "skeleton",
      [options, &common = registry.common] {
        const fs::path source = options->source.empty()
                                    ? data_folder() / "scenes" / "characters" / "human.toml"
                                    : fs::path(options->source);
        const skin::Character character = made_body(
            source, options->hints, {.vertices = options->vertices, .poll = poll_interrupt});
        const fs::path file(options->output);
        OutputFolder(file.parent_path()).write(file.filename(), skin::encode_glb(character));
        if (!common.quiet) {
          std::fprintf(stderr, "wrote %s: %zu vertices, %zu triangles, %zu joints\n", file.c_str(),
                       character.vertex_count(), character.triangles.size(),
                       character.joints.size());
        }
        return 0;
      });
  command->add_option("source", options->source,
                      "body description .toml, or a skeleton: .glb, .gltf, .fbx, .dae, .bvh "
                      "[the bundled human]");
  command
      ->add_option("--vertices", options->vertices,
                   "approximate number of vertices [the description's]")
      ->check(CLI::Range(1000, 20'000'000));
  command->add_option("-o,--output", options->output, "the .glb to write")->required();
  add_anatomy_options(command, options->hints);
}

void add_bake(const Registry& registry) {
  struct Options {
    std::string character, rig = "even", sweep = "extension", mapping = "chest", output;
    double frames_per_second = 24.0;
    skin::AnatomyHints hints;
    ExternalOptions external;
  };
  auto options = std::make_shared<Options>();
  CLI::App* command = registry.add(
      "bake", "write a rig's sweep as a skinned animation, .glb",
      [options, &common = registry.common] {
        ConfirmedCharacter confirmed = load_confirmed(options->character, options->hints);
        const Stage stage(
            std::move(confirmed.character), confirmed.hints, DrivenChain::spine,
            confirmed.sidecar ? confirmed.sidecar->controls : std::vector<skin::SidecarControl>());
        const auto system = stage.build(options->external.read_rig(options->rig).spec);
        const Sweep sweep = sweep_option(options->sweep);
        skin::GlbAnimation animation;
        animation.name = options->rig + "_" + sweep.name;
        for (std::size_t i = 0; i < sweep.pose_count(); ++i) {
          poll_interrupt();
          animation.time.push_back(
              static_cast<float>(static_cast<double>(i) / options->frames_per_second));
          const auto control = controls_at(*system, sweep.pose_at(sweep.control_at(i)),
                                           *find_mapping(options->mapping));
          animation.world_from_node.push_back(stage.pose(*system, control).world_from_node);
        }
        const fs::path file(options->output);
        OutputFolder(file.parent_path())
            .write(file.filename(), skin::encode_glb(stage.character(), &animation));
        if (!common.quiet)
          std::fprintf(stderr, "wrote %s: %zu frames\n", file.c_str(), animation.time.size());
        return 0;
      });
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
  command->add_option("-o,--output", options->output, "the .glb to write")->required();
  add_anatomy_options(command, options->hints);
}

}  // namespace backbend::cli
