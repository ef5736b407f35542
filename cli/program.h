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

/// What the command line leaves open, from the environment and the project; says on standard error
/// what a result depends on. Returns the project's file, empty where none counts. Throws
/// CLI::ParseError, ReadError, SuiteError.
std::filesystem::path take_surroundings(Program& program);

void add_config(const Registry& registry);

}  // namespace backbend::cli
