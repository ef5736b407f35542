#pragma once
#include "cli/commands.h"

namespace backbend::cli {

/// The program's command line: every command with its options, none of them said yet.
struct Program {
  CLI::App app;
  Common common;
  Run chosen;  // by parsing

  Program();
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  /// The command that a parsed line names.
  CLI::App& command() { return *app.get_subcommands().front(); }
};

void add_config(const Registry& registry);

}  // namespace backbend::cli
