#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "skin/clip/clip.h"
#include "validate/clips/clip_measure.h"

namespace backbend::validate {

/// What the tests of a clip could have found and could not, a line each: jumps over all of it;
/// where it holds its controls, the smallest jump that is surely found in each sweep, and the
/// sweeps that are too coarse for jumps of 10 degrees; and kinks. A report shows these beside its
/// findings, so that no clip is called clean of what it hides.
std::vector<std::string> clip_sensitivity(const RigRecord& record);

/// The command that asks the rig itself, which is bisected: `backbend check hero.glb --rig
/// blender:hero.blend`, as far as the clip says what wrote it. `character` may be empty.
std::string live_command(const skin::Clip& clip, const std::filesystem::path& character);

/// Whether a live rig would tell more than the clip does: a sweep is too coarse, or a kink may
/// hide.
bool is_better_asked_live(const RigRecord& record);

}  // namespace backbend::validate
