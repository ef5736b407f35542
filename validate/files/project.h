#pragma once
#include <cstddef>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "validate/files/output_folder.h"

namespace backbend::validate {

/// A project file that cannot be used. what() is the whole line: file:line, cause, hint.
struct ProjectError : ReadError {
  using ReadError::ReadError;
};

/// The name that a project file has where it is looked for.
inline constexpr const char* kProjectFile = "backbend.toml";

/// What the value of a key is in TOML. `texts`: a list of texts, or one.
enum class ProjectKind { flag, number, text, texts };

/// The keys that a project file may have: table, then key. The table "" is the top of the file.
using ProjectKeys = std::map<std::string, std::map<std::string, ProjectKind>>;

/// The value of a key, in the words that a command line would say it with; a flag is `true` or
/// `false`.
struct ProjectValue {
  std::vector<std::string> words;
  std::size_t line = 0;
};

/// A project's defaults for the options of commands.
struct Project {
  std::filesystem::path file;
  bool was_named = false;  // by a person, and not found beside files of others
  std::map<std::string, std::map<std::string, ProjectValue>> values;

  /// What a command takes for an option: what its own table says, else what the top says; null
  /// where neither does.
  const ProjectValue* find(const std::string& command, const std::string& option) const;
};

/// The nearest project file in the folder of `start` (or in `start` itself, where it is a folder)
/// or above it, up to the root of the file system. Links in the folder's path are resolved first;
/// a file that is itself a link belongs where the link is. None: there is no such file.
std::optional<std::filesystem::path> find_project(const std::filesystem::path& start);

/// Reads a project file's text. Throws ProjectError naming `file`, line and the nearest key for
/// every unknown table or key and every value of the wrong type.
Project parse_project(std::string_view text, const std::filesystem::path& file,
                      const ProjectKeys& keys);
/// The same from disk; at most 1 MiB. Throws ReadError, too.
Project read_project(const std::filesystem::path& file, const ProjectKeys& keys);

}  // namespace backbend::validate
