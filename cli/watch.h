#pragma once
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "cli/commands.h"

namespace backbend::cli {

/// What `check --watch` does again whenever one of its inputs changes.
struct WatchedRun {
  std::vector<std::filesystem::path> inputs;
  std::string output;        // run folder; empty: runs/DATE_TIME
  bool pictures = true;      // made after the verdict, and it again with them
  bool single_file = false;  // every picture inside the page
  bool poll = false;         // looks at the files even where the system would tell
  std::function<validate::Report(const std::filesystem::path& folder, bool pictures,
                                 const std::shared_ptr<validate::KnownJumps>& known_jumps,
                                 validate::Progress& progress)>
      judge;  // `known_jumps` stay from save to save
};

/// The words that the process was started with: options are taken anew when a project file changes.
void remember_command_line(int count, char** arguments);

/// Judges, shows the verdict, makes the pictures, and starts again when an input has changed, until
/// a signal ends it (Interrupted). Bad input ends the first run alone; later it is shown, and the
/// next save waited for. Throws what judging throws, WriteError.
int watch(WatchedRun run, const Common& common);

}  // namespace backbend::cli
