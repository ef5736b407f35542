#include <cstdio>

#include "cli/commands.h"
#include "skin/anatomy.h"
#include "skin/inspect.h"
#include "validate/run/stage.h"

namespace backbend::cli {

void add_inspect(const Registry& registry) {
  struct Options {
    std::string character;
    skin::AnatomyHints hints;
  };
  auto options = std::make_shared<Options>();
  CLI::App* command =
      registry.add("inspect", "a character's skeleton, spine and weights, and what would be driven",
                   [options, &common = registry.common] {
                     const skin::Character character = validate::load_character(options->character);
                     const skin::Anatomy anatomy = skin::find_anatomy(character, options->hints);
                     const std::string text = common.json ? skin::inspect_json(character, anatomy)
                                                          : skin::inspect_text(character, anatomy);
                     std::printf("%s\n", text.c_str());
                     return 0;
                   });
  command
      ->add_option("character", options->character,
                   "character file: .glb, .gltf, or a body description .toml")
      ->required();
  add_anatomy_options(command, options->hints);
}

}  // namespace backbend::cli
