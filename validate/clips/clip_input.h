#pragma once
#include <filesystem>
#include <memory>
#include <optional>

#include "skin/anatomy/anatomy.h"
#include "skin/anatomy/sidecar.h"
#include "skin/clip/clip.h"
#include "validate/clips/clip_body.h"
#include "validate/stage/stage.h"

namespace backbend::validate {

/// Which clip, on which body.
struct ClipFiles {
  std::filesystem::path character;  // empty: the clip's own body, or its skeleton alone
  std::filesystem::path clip;       // anything of skin::read_clip(), or .fbx, .dae, .bvh
  skin::ClipOptions options;
  skin::AnatomyHints hints;
  JointMap names;
};

/// A clip that was read, and the body that it moves, whose chain goes up to the neck.
struct ClipInput {
  skin::Clip clip;
  std::optional<skin::Sidecar> sidecar;  // beside the character, or without one beside the clip
  std::unique_ptr<const Stage> stage;    // null: neither the clip nor a character has a body
  skin::AnatomyHints hints;              // with the sidecar's
};

/// Reads both, and the sidecar, which counts for the clip's names and unit, too. Throws
/// CharacterError.
ClipInput read_clip_input(const ClipFiles& files);

}  // namespace backbend::validate
