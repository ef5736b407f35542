#pragma once
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "validate/serve/file_access.h"

namespace backbend::validate {

/// What the value of an argument stands for.
enum class ArgumentKind {
  word,     // taken as it is
  choice,   // one of `choices`
  number,   // a whole number from `low` to `high`
  file,     // read; inside the server's folders
  rig,      // a system with options, or a rig file; never one that starts a program
  subject,  // what compare takes: a rig, or a file or folder
  output,   // written; only where the server may write
};

struct ToolArgument {
  std::string_view name;         // `character`
  std::string_view option;       // `--rig`; empty: a positional word
  std::string_view description;  // with unit and default
  ArgumentKind kind = ArgumentKind::word;
  bool required = false;
  std::vector<std::string_view> choices{};
  int low = 0, high = 0;
};

/// A command as an agent sees it.
struct Tool {
  std::string_view name, title, description;
  std::vector<std::string_view> words;  // the command and options that every call has
  std::vector<ToolArgument> arguments;
  bool gives_picture = false;  // PNG on standard output instead of JSON
};

std::span<const Tool> all_tools();
const Tool* find_tool(std::string_view name);

/// Arguments that cannot be used. what() says which and what was expected.
struct ArgumentError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// How a tool is listed (MCP, `tools/list`). Outputs are among its arguments only with `may_write`.
nlohmann::json tool_description(const Tool& tool, bool may_write);

/// The words of the command line that a call stands for, the command first: what is not given an
/// output writes nothing. No value can be taken for an option. Throws ArgumentError, AccessError.
std::vector<std::string> words_of(const Tool& tool, const nlohmann::json& arguments,
                                  const FileAccess& files, bool may_write);

}  // namespace backbend::validate
