#pragma once
#include <CLI/CLI.hpp>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "validate/files/project.h"

namespace backbend::cli {

// Where options that the command line does not give come from: BACKBEND_* variables, then the
// nearest project file, then the default. An option is one that these may set where its command's
// table says `configurable()`; its name is the project's key, and with BACKBEND_ the variable's.

/// Of an option's value in the project file: FILE is relative to it, RIG where it names a file.
inline constexpr const char* kFileType = "FILE";
inline constexpr const char* kRigType = "RIG";

enum class Origin { preset, project, environment, command_line };

/// What one option of one command has, and where from.
struct Setting {
  std::string option;
  std::vector<std::string> words;  // none: the default, if it has one
  std::string shown;               // for people: the words, or the default as --help tells it
  Origin origin = Origin::preset;
  std::string place;  // FILE:LINE, or the variable
};

/// `rig` of --rig, `suite` of a positional: the key of an option.
std::string key_of(const CLI::Option& option);
/// `BACKBEND_RIG`.
std::string variable_of(const CLI::Option& option);
/// The options that a project or the environment may set.
std::vector<CLI::Option*> settable_options(CLI::App& app);
/// Commands that show built-in defaults ignore project files.
bool takes_settings(const CLI::App& command);

/// The keys that a project file may have for the commands of `app`.
validate::ProjectKeys project_keys(CLI::App& app);

/// The project that counts for a command whose line was parsed: --project's, BACKBEND_PROJECT's, or
/// the nearest above what is judged, which is the first file or folder that the line names; above
/// the working folder where it names none. None with --no-project. Throws ReadError.
std::optional<validate::Project> project_for(CLI::App& app, const CLI::App& command);
/// The same for a file that is not on a command's line; empty: the working folder.
std::optional<validate::Project> project_at(CLI::App& app, const std::filesystem::path& file);

/// Sets every settable option of `app` and of its `command` that the command line does not give, as
/// if it were given there, and returns the value and origin of each. Throws CLI::ParseError naming
/// the variable, ProjectError naming the line, where a value is not taken.
std::vector<Setting> take_settings(CLI::App& app, CLI::App& command,
                                   const validate::Project* project);

/// `backbend: rig, spp from /show/backbend.toml; res from BACKBEND_RES`: what a result depends on
/// and the command line does not say; empty: nothing.
std::string note_of(const std::vector<Setting>& settings);

}  // namespace backbend::cli
