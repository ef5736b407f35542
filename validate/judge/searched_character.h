#pragma once
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "skin/anatomy/anatomy.h"
#include "skin/anatomy/sidecar.h"
#include "validate/model/report.h"
#include "validate/stage/stage.h"
#include "validate/sweeps/envelope.h"
#include "validate/sweeps/suite.h"

namespace backbend::validate {

/// A character on which one rig's poses or options are searched.
struct SearchedCharacter {
  std::unique_ptr<Stage> stage;  // with the mesh of a studio's own rig where it has another
  std::optional<skin::Sidecar> sidecar;
  Envelope envelope;
  CharacterFacts facts;
};

/// Loads the character as it was confirmed, refuses what `check` would, and chooses the envelope:
/// by this name, else the sidecar's, else that of the kind of body. Throws skin::CharacterError,
/// solver::RigError.
SearchedCharacter load_searched(const std::filesystem::path& file, const skin::AnatomyHints& hints,
                                DrivenChain chain, const RigPlan& rig, const std::string& envelope);

}  // namespace backbend::validate
