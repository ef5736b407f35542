#include "validate/judge/confirmed.h"

#include "validate/stage/stage.h"

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
    throw skin::CharacterError(skin::sidecar_path(file).string() + ": " + *difference +
                               "; run backbend inspect --save again");
  return out;
}

}  // namespace backbend::validate
