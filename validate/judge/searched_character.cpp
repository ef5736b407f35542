#include "validate/judge/searched_character.h"

#include "skin/anatomy/body_kind.h"
#include "skin/anatomy/import_checks.h"
#include "validate/judge/confirmed.h"

namespace backbend::validate {

SearchedCharacter load_searched(const std::filesystem::path& file, const skin::AnatomyHints& hints,
                                DrivenChain chain, const RigPlan& rig,
                                const std::string& envelope) {
  ConfirmedCharacter confirmed = load_confirmed(file, hints);
  skin::require_possible_import(confirmed.character);
  const std::vector<skin::SidecarControl> controls =
      confirmed.sidecar ? confirmed.sidecar->controls : std::vector<skin::SidecarControl>();
  SearchedCharacter out;
  out.stage =
      std::make_unique<Stage>(std::move(confirmed.character), confirmed.hints, chain, controls);
  if (auto with_its_mesh = out.stage->with_mesh_of(rig.spec))
    out.stage =
        std::make_unique<Stage>(std::move(*with_its_mesh), confirmed.hints, chain, controls);
  const Stage& stage = *out.stage;
  const skin::BodyKindChoice kind = skin::body_kind(
      stage.character(), chain == DrivenChain::neck
                             ? skin::find_anatomy(stage.character(), confirmed.hints)
                             : stage.anatomy());
  out.envelope = envelope_for(kind.kind, chain == DrivenChain::neck);
  if (confirmed.sidecar && !confirmed.sidecar->envelope.empty())
    if (const auto own = find_envelope(confirmed.sidecar->envelope)) out.envelope = *own;
  if (!envelope.empty()) out.envelope = *find_envelope(envelope);
  out.facts = facts_of(stage.character(), stage.anatomy(), out.envelope.name);
  out.facts.kind = skin::name_of(kind.kind);
  out.facts.kind_reason = kind.reason;
  out.facts.envelope_reason = kind.reason + "; " + out.envelope.text();
  out.sidecar = std::move(confirmed.sidecar);
  stage.build(rig.spec);  // what is wrong with the rig is said first
  return out;
}

}  // namespace backbend::validate
