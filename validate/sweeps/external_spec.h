#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "solver/rig/spine_system.h"

namespace backbend::validate {

/// The name of the system that stands for a studio's own rig, evaluated by another program while it
/// is judged.
inline constexpr std::string_view kExternal = "external";

/// How a studio's own rig is reached. As options of a solver::SystemSpec: program, file or command,
/// map, servers, timeout.
struct ExternalSpec {
  std::string program;    // `blender`, `maya`, or `command`
  std::string file;       // of the program: hero.blend
  std::string command;    // `PROGRAM ARGS` of `command`
  std::string map;        // which controls stand for which channel: a file, which is that of the
                          // preset where its name was given; empty: the sidecar's
  int servers = 1;        // that are asked side by side; of no interest to results
  double timeout = 60.0;  // seconds for which a server may be silent
};

bool is_external(const solver::SystemSpec& spec);

/// `blender:hero.blend`, `maya:hero.ma` or `command:PROGRAM ARGS`; nullopt for another text. Throws
/// RigError where nothing stands behind the colon.
std::optional<solver::SystemSpec> parse_external(const std::string& text);
/// The text that parse_external() makes the same of, without map, servers and timeout.
std::string external_text(const solver::SystemSpec& spec);
/// What tells one running rig from another: its text and its mapping.
std::string external_key(const solver::SystemSpec& spec);
/// What the rig is called: its file, or the script that its command runs, else the program, without
/// folder and ending.
std::string external_name(const solver::SystemSpec& spec);

/// The options, checked. Throws RigError naming the one that is missing, unknown or wrong.
ExternalSpec external_spec(const solver::SystemSpec& spec);

/// Splits a command at blanks, as a shell would: quotes ' and " hold words together, a backslash
/// takes the next character as it is. Nothing else is special. Throws RigError for an open quote.
std::vector<std::string> split_command(const std::string& command);

/// The files that a rig's poses depend on beside its text, as it names them, where they are there:
/// its file, its mapping, and those that its command names.
std::vector<std::string> external_files(const solver::SystemSpec& spec);
/// Hashes of those.
std::string external_inputs(const solver::SystemSpec& spec);

}  // namespace backbend::validate
