#include <cstdio>

#include "cli/commands.h"
#include "skin/anatomy/anatomy.h"
#include "skin/anatomy/driven_nodes.h"
#include "skin/anatomy/import_checks.h"
#include "skin/anatomy/sidecar.h"
#include "skin/gltf/gltf_reader.h"
#include "skin/weights/inspect.h"
#include "skin/weights/weight_suggestions.h"
#include "validate/files/import.h"
#include "validate/files/output_folder.h"
#include "validate/judge/confirmed.h"
#include "validate/live/propose_mapping.h"
#include "validate/sweeps/external_spec.h"

namespace backbend::cli {

namespace {

/// Writes what was found beside the character, for a person to confirm; its path.
std::filesystem::path save_sidecar(const std::string& character, const skin::Sidecar& sidecar) {
  const std::filesystem::path path = skin::sidecar_path(character);
  const std::string text = skin::sidecar_text(sidecar);
  if (skin::parse_sidecar(text, path) != sidecar)  // names that TOML cannot hold
    throw skin::CharacterError(path.string() + ": the character's names are not writable");
  validate::OutputFolder(path.parent_path()).write(path.filename(), text);
  return path;
}

/// What there is to inspect: a character with the sidecar beside it, or a skeleton alone.
validate::ConfirmedCharacter load_inspected(const std::filesystem::path& file,
                                            const skin::AnatomyHints& hints,
                                            bool about_to_confirm) {
  try {
    return validate::load_confirmed(file, hints, about_to_confirm);
  } catch (const skin::NoMeshError&) {
    validate::ConfirmedCharacter out{{}, hints, skin::read_sidecar(file)};
    try {
      out.character = skin::read_skeleton(validate::load_document(file));
    } catch (const skin::CharacterError&) {  // neither: what was wrong first is what counts
    }
    if (out.character.nodes.empty()) throw;
    out.character.warnings.push_back(
        {"no_mesh", "no triangles to judge; backbend body makes a body for a skeleton"});
    if (!out.sidecar) return out;
    skin::apply_sidecar(*out.sidecar, out.character);
    out.hints = skin::hints_with(*out.sidecar, std::move(out.hints));
    return out;
  }
}

/// The rig of one's own that --rig names.
solver::SystemSpec own_rig(const std::string& text) {
  const auto spec = validate::parse_external(text);
  if (!spec)
    throw CLI::ValidationError(
        "--rig: expected blender:FILE, maya:FILE or command:\"PROGRAM ARGS\", got '" + text + "'");
  return *spec;
}

/// The character of a rig that is named alone: its own export beside it.
std::string export_of(const std::string& rig) {
  const std::string file = validate::external_spec(own_rig(rig)).file;
  if (file.empty())
    throw CLI::ValidationError("character: required beside --rig command:\"PROGRAM ARGS\"");
  return std::filesystem::path(file).replace_extension(".glb").string();
}

}  // namespace

void add_inspect(const Registry& registry) {
  struct Options {
    std::string character, rig;
    skin::AnatomyHints hints;
    bool save = false, suggest = false, driven = false;
  };
  auto options = std::make_shared<Options>();
  CLI::App* command = registry.add(
      "inspect", "show a character's skeleton, spine, weights and driven joints",
      [options, &common = registry.common] {
        if (options->character.empty() && options->rig.empty())
          throw CLI::RequiredError("character");
        if (options->character.empty()) options->character = export_of(options->rig);
        const validate::ConfirmedCharacter confirmed =
            load_inspected(options->character, options->hints, options->save);
        const skin::Character& character = confirmed.character;
        const skin::Anatomy anatomy = skin::find_anatomy(character, confirmed.hints);
        std::string text = common.json ? skin::inspect_json(character, anatomy)
                                       : skin::inspect_text(character, anatomy);
        if (options->suggest && character.vertex_count() == 0)
          throw skin::CharacterError(character.file_name +
                                     ": no mesh, so no weights to suggest for");
        if (options->suggest) {
          const auto suggestions =
              skin::suggest_weights(character, skin::judge_weights(character, anatomy));
          text = common.json ? skin::suggestions_json(character.file_name, suggestions)
                             : skin::suggestions_text(suggestions);
        }
        if (options->driven) {
          const auto nodes = skin::driven_nodes(character, anatomy);
          text = common.json ? skin::driven_json(character, nodes)
                             : skin::driven_text(character, nodes);
        }
        skin::Sidecar known = confirmed.sidecar.value_or(skin::Sidecar{});
        if (!options->rig.empty()) {
          const validate::ProposedMapping proposal =
              validate::propose_mapping(own_rig(options->rig), character, anatomy);
          text = common.json ? validate::proposal_json(proposal)
                             : text + "\n" + validate::proposal_text(proposal);
          known.controls = proposal.controls();
        }
        if (options->save) {
          const auto path = save_sidecar(options->character,
                                         skin::sidecar_of(character, anatomy, std::move(known)));
          if (!common.quiet)
            std::fprintf(stderr, "wrote %s: check it once and correct what is wrong\n",
                         path.c_str());
        }
        std::printf("%s\n", text.c_str());
        // Everything is shown; then the error of `check` for such a file is reported.
        std::fflush(stdout);
        skin::require_possible_import(character);
        return 0;
      });
  command->add_option(
      "character", options->character,
      "character file: .glb, .gltf, .fbx, .dae, a skeleton .bvh, or a body description .toml "
      "[of --rig blender:hero.blend: hero.glb beside it]");
  command->add_option(
      "--rig", options->rig,
      "try the controls of a rig of your own, blender:FILE, maya:FILE or command:\"PROGRAM "
      "ARGS\", and propose which stand for which channel");
  command->add_flag("--save", options->save,
                    "write what was found to NAME.backbend.toml beside the character");
  CLI::Option* suggest = command->add_flag("--suggest", options->suggest,
                                           "suggest how to clean the weights; changes nothing");
  command
      ->add_flag(
          "--driven", options->driven,
          "show for every joint whether our rigs drive it, what it follows, or that it is still")
      ->excludes(suggest);
  add_anatomy_options(command, options->hints);
}

}  // namespace backbend::cli
