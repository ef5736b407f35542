#include <cstdio>

#include "cli/commands.h"
#include "skin/body/body.h"
#include "skin/body/body_proxy.h"
#include "skin/gltf/glb_writer.h"
#include "skin/gltf/gltf_reader.h"
#include "validate/files/data_folder.h"
#include "validate/files/import.h"
#include "validate/files/output_folder.h"

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

}  // namespace backbend::cli
