#pragma once
#include <functional>
#include <string>

#include "validate/clips/clip_input.h"
#include "validate/model/report.h"
#include "validate/sweeps/suite.h"
#include "validate/tasks/progress.h"

namespace backbend::validate {

/// A baked clip to judge: `check [CHARACTER] --baked CLIP`.
struct ClipRequest : ClipFiles {
  std::string command;  // as the user typed it, for reproduce lines

  std::filesystem::path folder;  // for pictures; empty: none are made
  PicturePlan pictures;

  /// Called as soon as the clip lies on the character, before anything is measured.
  std::function<void(const std::string& title, const CharacterFacts&)> on_character;
};

/// Judges motion that another program solved: flips, kinks and arm pops of the chain, and the
/// surface against an even bend with the same ends and weights (specification 6 and 8).
///
/// Frames cannot be bisected, so a flip is an outlier of the clip's own motion, and the report
/// states the smallest one that would have been found. Every frame lies inside the envelope: the
/// clip is what the character must do.
///
/// A clip without a body of its own (BVH, joints alone) and without a character is judged by its
/// chain. A sidecar beside the character (or, without one, beside the clip) counts, for the clip's
/// names and unit, too. Throws CharacterError, Interrupted.
Report run_clip(const ClipRequest& request, Progress& progress);

}  // namespace backbend::validate
