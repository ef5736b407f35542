#include "validate/clips/clip_input.h"

#include "skin/anatomy/import_checks.h"
#include "validate/files/import.h"
#include "validate/judge/confirmed.h"

namespace backbend::validate {
namespace {

skin::Clip load_clip(const std::filesystem::path& file, const skin::ClipOptions& options) {
  if (!is_imported(file)) return skin::read_clip(file, options);
  skin::Clip clip = skin::read_gltf_clip(import_document(file), options);
  clip.source.clear();  // what the import calls itself says nothing of the motion
  return clip;
}

}  // namespace

ClipInput read_clip_input(const ClipFiles& files) {
  ClipInput out;
  out.clip = load_clip(files.clip, files.options);
  out.hints = files.hints;
  const bool own_body = files.character.empty() && out.clip.has_body;
  if (files.character.empty() && !own_body) {
    out.sidecar = skin::read_sidecar(files.clip);
    if (out.sidecar) {
      skin::apply_sidecar(*out.sidecar, out.clip);
      out.hints = skin::hints_with(*out.sidecar, std::move(out.hints));
    }
    return out;
  }
  ConfirmedCharacter confirmed =
      load_confirmed(own_body ? files.clip : files.character, std::move(out.hints));
  skin::require_possible_import(confirmed.character);
  if (confirmed.sidecar) skin::apply_sidecar(*confirmed.sidecar, out.clip);
  skin::Anatomy anatomy =
      up_to_the_neck(confirmed.character, skin::find_anatomy(confirmed.character, confirmed.hints));
  out.hints = std::move(confirmed.hints);
  out.sidecar = std::move(confirmed.sidecar);
  out.stage = std::make_unique<const Stage>(std::move(confirmed.character), std::move(anatomy));
  return out;
}

}  // namespace backbend::validate
