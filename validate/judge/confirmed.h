#pragma once
#include <filesystem>
#include <optional>

#include "skin/anatomy/anatomy.h"
#include "skin/anatomy/sidecar.h"
#include "validate/model/report.h"

namespace backbend::validate {

/// A character as a person confirmed it, ready for a Stage.
struct ConfirmedCharacter {
  skin::Character character;
  skin::AnatomyHints hints;              // from the command line first, then the sidecar
  std::optional<skin::Sidecar> sidecar;  // if the file has one
};

/// load_character() with the sidecar beside it, if there is one: it counts as part of the content.
/// Throws skin::CharacterError also for a broken sidecar, and where the character no longer matches
/// what was confirmed (unless it is being confirmed again).
ConfirmedCharacter load_confirmed(const std::filesystem::path& file, skin::AnatomyHints hints,
                                  bool about_to_confirm = false);

/// The command by which a person confirms how a character was understood.
std::string confirm_command(const std::filesystem::path& file);

/// How a character was understood, for the head of a report.
CharacterFacts facts_of(const skin::Character& character, const skin::Anatomy& anatomy,
                        const std::string& envelope);

}  // namespace backbend::validate
