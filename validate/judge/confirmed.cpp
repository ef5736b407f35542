#include "validate/judge/confirmed.h"

#include "validate/files/hash.h"
#include "validate/stage/stage.h"
#include "validate/text/shell_word.h"

namespace backbend::validate {

ConfirmedCharacter load_confirmed(const std::filesystem::path& file, skin::AnatomyHints hints,
                                  bool about_to_confirm) {
  // The sidecar is read first: what is wrong with it should not wait for a large character.
  std::optional<skin::Sidecar> sidecar = skin::read_sidecar(file);
  ConfirmedCharacter out{load_character(file), std::move(hints), std::move(sidecar)};
  if (!out.sidecar) return out;
  skin::apply_sidecar(*out.sidecar, out.character);
  out.hints = skin::hints_with(*out.sidecar, std::move(out.hints));
  if (about_to_confirm) return out;
  if (const auto difference =
          skin::contradiction(*out.sidecar, skin::find_anatomy(out.character, out.hints)))
    throw skin::CharacterError(skin::sidecar_path(file).string() + ": " + *difference);
  return out;
}

namespace {

std::vector<std::string> names_of(const skin::Character& character, const std::vector<int>& nodes) {
  std::vector<std::string> names;
  for (const int node : nodes)
    names.push_back(character.nodes[static_cast<std::size_t>(node)].name);
  return names;
}

}  // namespace

std::string confirm_command(const std::filesystem::path& file) {
  return "backbend inspect " + shell_word(file.string()) + " --save";
}

CharacterFacts facts_of(const skin::Character& character, const skin::Anatomy& anatomy,
                        const std::string& envelope) {
  CharacterFacts facts;
  facts.name = character.name;
  facts.file = character.file_name;
  facts.hash = hash_text(character.content_hash_high, character.content_hash_low);
  facts.meshes = static_cast<int>(character.parts.size());
  facts.vertices = static_cast<int>(character.vertex_count());
  facts.triangles = static_cast<int>(character.triangles.size());
  facts.joints = static_cast<int>(character.joints.size());
  facts.height = anatomy.height;
  facts.spine_length = anatomy.spine_length;
  const auto driven = static_cast<std::ptrdiff_t>(anatomy.chest_index) + 1;
  facts.spine = names_of(character, {anatomy.spine.begin(), anatomy.spine.begin() + driven});
  facts.left_arm = names_of(character, anatomy.left_arm);
  facts.right_arm = names_of(character, anatomy.right_arm);
  facts.doubts = anatomy.doubts;
  facts.envelope = envelope;
  for (const skin::Warning& warning : character.warnings) facts.notes.push_back(warning.message);
  return facts;
}

}  // namespace backbend::validate
