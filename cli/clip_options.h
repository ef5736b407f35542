#pragma once
#include "cli/commands.h"
#include "validate/clips/clip_input.h"

namespace backbend::cli {

/// --baked and what belongs to it, as add_baked_options() adds them; `what`: what the command does
/// with the clip.
CLI::Option* add_clip_options(CLI::App* command, BakedOptions& options, const std::string& what);

/// The clip on a character (empty: its own body), as it is read.
validate::ClipFiles clip_files(const BakedOptions& options, const std::string& character,
                               const skin::AnatomyHints& hints);

}  // namespace backbend::cli
