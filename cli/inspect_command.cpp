#include <cstdio>

#include "cli/commands.h"
#include "skin/anatomy.h"
#include "skin/inspect.h"
#include "skin/sidecar.h"
#include "skin/weight_suggestions.h"
#include "validate/files/output_folder.h"
#include "validate/run/confirmed.h"

namespace backbend::cli {

namespace {

/// Writes what was found beside the character, for a person to confirm; its path.
std::filesystem::path save_sidecar(const std::string& character, const skin::Sidecar& sidecar) {
  const std::filesystem::path path = skin::sidecar_path(character);
  const std::string text = skin::sidecar_text(sidecar);
  if (skin::parse_sidecar(text, path) != sidecar)  // names that TOML cannot hold
    throw skin::CharacterError(path.string() + ": the character's names cannot be written");
  validate::OutputFolder(path.parent_path()).write(path.filename(), text);
  return path;
}

}  // namespace

void add_inspect(const Registry& registry) {
  struct Options {
    std::string character;
    skin::AnatomyHints hints;
    bool save = false, suggest = false;
  };
  auto options = std::make_shared<Options>();
  CLI::App* command = registry.add(
      "inspect", "a character's skeleton, spine and weights, and what would be driven",
      [options, &common = registry.common] {
        const validate::ConfirmedCharacter confirmed =
            validate::load_confirmed(options->character, options->hints, options->save);
        const skin::Character& character = confirmed.character;
        const skin::Anatomy anatomy = skin::find_anatomy(character, confirmed.hints);
        std::string text = common.json ? skin::inspect_json(character, anatomy)
                                       : skin::inspect_text(character, anatomy);
        if (options->suggest) {
          const auto suggestions =
              skin::suggest_weights(character, skin::judge_weights(character, anatomy));
          text = common.json ? skin::suggestions_json(character.file_name, suggestions)
                             : skin::suggestions_text(suggestions);
        }
        if (options->save) {
          const auto path = save_sidecar(
              options->character,
              skin::sidecar_of(character, anatomy, confirmed.sidecar.value_or(skin::Sidecar{})));
          if (!common.quiet)
            std::fprintf(stderr, "wrote %s: read it once, and correct what is wrong\n",
                         path.c_str());
        }
        std::printf("%s\n", text.c_str());
        return 0;
      });
  command
      ->add_option("character", options->character,
                   "character file: .glb, .gltf, .fbx, .dae, or a body description .toml")
      ->required();
  command->add_flag("--save", options->save,
                    "write what was found to NAME.backbend.toml beside the character");
  command->add_flag("--suggest", options->suggest,
                    "what would make the weights cleaner; changes nothing");
  add_anatomy_options(command, options->hints);
}

}  // namespace backbend::cli
