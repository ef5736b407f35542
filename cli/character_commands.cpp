#include <cstdio>

#include "cli/commands.h"
#include "skin/body.h"
#include "skin/glb_writer.h"
#include "validate/files/data_folder.h"
#include "validate/files/output_folder.h"
#include "validate/run/measure.h"
#include "validate/run/stage.h"
#include "validate/sweeps/suite.h"

namespace backbend::cli {

namespace fs = std::filesystem;
using namespace backbend::validate;

namespace {

Sweep sweep_named(const std::string& name) {
  std::vector<std::string> names;
  for (const Sweep& sweep : standard_sweeps()) {
    if (sweep.name == name) return sweep;
    names.push_back(sweep.name);
  }
  const auto near = nearest_name(name, names);
  throw CLI::ValidationError("no sweep '" + name + "'" +
                             (near ? ", did you mean '" + *near + "'?" : "") +
                             "; backbend list sweeps shows all");
}

}  // namespace

void add_body(const Registry& registry) {
  struct Options {
    std::string description, output;
    int vertices = 0;
  };
  auto options = std::make_shared<Options>();
  CLI::App* command = registry.add(
      "body", "make a character from a description: a closed mesh with smooth weights, as .glb",
      [options, &common = registry.common] {
        const fs::path description = options->description.empty()
                                         ? data_folder() / "scenes" / "characters" / "human.toml"
                                         : fs::path(options->description);
        const skin::Character character =
            skin::make_body(skin::read_body_description(description),
                            {.vertices = options->vertices, .poll = poll_interrupt});
        const fs::path file(options->output);
        OutputFolder(file.parent_path()).write(file.filename(), skin::encode_glb(character));
        if (!common.quiet) {
          std::fprintf(stderr, "wrote %s: %zu vertices, %zu triangles, %zu joints\n", file.c_str(),
                       character.vertex_count(), character.triangles.size(),
                       character.joints.size());
        }
        return 0;
      });
  command->add_option("description", options->description,
                      "body description .toml [the bundled human]");
  command
      ->add_option("--vertices", options->vertices,
                   "how many vertices, about [what the description says]")
      ->check(CLI::Range(1000, 20'000'000));
  command->add_option("-o,--output", options->output, "the .glb to write")->required();
}

void add_bake(const Registry& registry) {
  struct Options {
    std::string character, rig = "curve", sweep = "extension", mapping = "chest", output;
    double frames_per_second = 24.0;
    skin::AnatomyHints hints;
  };
  auto options = std::make_shared<Options>();
  CLI::App* command = registry.add(
      "bake", "a rig's sweep as a skinned animation, .glb, that every viewer plays",
      [options, &common = registry.common] {
        const Stage stage(load_character(options->character), options->hints);
        const auto system = stage.build(read_rig(options->rig).spec);
        const Sweep sweep = sweep_named(options->sweep);
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
                   "character file: .glb, .gltf, or a body description .toml")
      ->required();
  command->add_option("--rig", options->rig,
                      "rig: a system (backbend list rigs) or a rig file [curve]");
  command->add_option("--sweep", options->sweep, "sweep (backbend list sweeps) [extension]");
  command->add_option("--mapping", options->mapping, "chest or spread [chest]")
      ->check(CLI::IsMember({"chest", "spread"}));
  command->add_option("--fps", options->frames_per_second, "frames a second, 1 to 1000 [24]")
      ->check(CLI::Range(1.0, 1000.0));
  command->add_option("-o,--output", options->output, "the .glb to write")->required();
  add_anatomy_options(command, options->hints);
}

}  // namespace backbend::cli
