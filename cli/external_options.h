#pragma once
#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "validate/sweeps/suite.h"

namespace backbend::cli {

inline constexpr const char* kRigHelp =
    "rig: a system (backbend list rigs), a rig file, or your own, live: blender:FILE, maya:FILE or "
    "command:\"PROGRAM ARGS\" [even]";

/// `--map` and `--servers`: how a studio's own rig (`blender:FILE`, `maya:FILE`, `command:"PROGRAM
/// ARGS"`) is asked.
struct ExternalOptions {
  std::string map;
  int servers = 0;  // 0: as its rig file says, or 1

  void add_to(CLI::App* command);
  /// Gives them to each rig that is a studio's own. Throws CLI::ValidationError where --map is
  /// given and none of them is.
  void apply_to(std::vector<validate::RigPlan*> rigs) const;
  /// read_rig() with them.
  validate::RigPlan read_rig(const std::string& text) const;
};

}  // namespace backbend::cli
