#include "validate/sweeps/external_spec.h"

#include <algorithm>
#include <filesystem>

#include "solver/rig/nearest_name.h"
#include "validate/files/data_folder.h"
#include "validate/files/hash.h"
#include "validate/files/output_folder.h"
#include "validate/sweeps/in_process_spec.h"

namespace backbend::validate {
namespace {

namespace fs = std::filesystem;
using solver::RigError;

const std::vector<std::string> kPrograms = {"blender", "maya", "command", std::string(kInProcess)};
constexpr double kMostServers = 64, kLeastTimeout = 0.1, kMostTimeout = 86'400;

std::string text_option(const solver::SystemSpec& spec, const std::string& key) {
  const auto found = spec.options.find(key);
  if (found == spec.options.end()) return {};
  const auto* text = std::get_if<std::string>(&found->second);
  if (text == nullptr || text->empty())
    throw RigError("external: option '" + key + "' must be text");
  return *text;
}

double number_option(const solver::SystemSpec& spec, const std::string& key, double least,
                     double most, double otherwise) {
  const auto found = spec.options.find(key);
  if (found == spec.options.end()) return otherwise;
  const auto* number = std::get_if<double>(&found->second);
  if (number == nullptr || !(*number >= least && *number <= most))
    throw RigError("external: option '" + key + "' must be a number from " +
                   std::to_string(least).substr(0, 3) + " to " +
                   std::to_string(static_cast<int>(most)));
  return *number;
}

/// `rigify` names a mapping that comes with the program, where no file is called so. Suites put
/// their folder before it.
std::string mapping_file(const std::string& map) {
  std::error_code none;
  const std::string name = fs::path(map).filename().string();
  if (map.empty() || fs::is_regular_file(map, none) ||
      name.find_first_not_of("abcdefghijklmnopqrstuvwxyz_") != std::string::npos)
    return map;
  const fs::path preset = data_folder() / "scenes/bridges/presets" / (name + ".json");
  return fs::is_regular_file(preset, none) ? preset.string() : map;
}

/// The options of the program that is named, and those that are missing.
void check_options(const solver::SystemSpec& spec, const ExternalSpec& out) {
  const std::string own = out.program == "command" ? "command" : "file";
  const std::vector<std::string> known = {"program", own, "map", "servers", "timeout"};
  for (const auto& [key, value] : spec.options)
    if (std::find(known.begin(), known.end(), key) == known.end())
      throw RigError("external: no option '" + key + "' of program = \"" + out.program + "\"" +
                     solver::did_you_mean(key, known));
  if (own == "command" ? out.command.empty() : out.file.empty())
    throw RigError("external: option '" + own + "' is missing: " +
                   (own == "command" ? "the program and its arguments" : "the scene with the rig"));
}

}  // namespace

bool is_external(const solver::SystemSpec& spec) { return spec.system == kExternal; }

std::optional<solver::SystemSpec> parse_external(const std::string& text) {
  const std::size_t colon = text.find(':');
  if (colon == std::string::npos) return std::nullopt;
  const std::string program = text.substr(0, colon), rest = text.substr(colon + 1);
  if (std::find(kPrograms.begin(), kPrograms.end(), program) == kPrograms.end())
    return std::nullopt;
  const std::string own = program == "command" ? "command" : "file";
  if (rest.find_first_not_of(' ') == std::string::npos)
    throw RigError("rig '" + text + "': expected " + program +
                   (own == "command" ? ":\"PROGRAM ARGS\"" : ":FILE"));
  return solver::SystemSpec{std::string(kExternal), {{"program", program}, {own, rest}}};
}

std::string external_text(const solver::SystemSpec& spec) {
  const std::string program = text_option(spec, "program");
  const std::string own = text_option(spec, program == "command" ? "command" : "file");
  return program + ":" + (program == kInProcess ? own.substr(0, own.find(kInProcessNumber)) : own);
}

std::string external_key(const solver::SystemSpec& spec) {
  const ExternalSpec external = external_spec(spec);
  return external_text(spec) + "\n" + external.map +
         (external.program == kInProcess ? "\n" + external.file : "");
}

std::string external_name(const solver::SystemSpec& spec) {
  const ExternalSpec external = external_spec(spec);
  if (external.program != "command") return fs::path(external.file).stem().string();
  const std::vector<std::string> words = split_command(external.command);
  // Of an interpreter, the script.
  for (std::size_t i = 1; i < words.size(); ++i)
    if (!words[i].starts_with('-') && fs::path(words[i]).has_extension())
      return fs::path(words[i]).stem().string();
  return fs::path(words.front()).stem().string();
}

ExternalSpec external_spec(const solver::SystemSpec& spec) {
  ExternalSpec out;
  out.program = text_option(spec, "program");
  if (out.program.empty())
    throw RigError("external: option 'program' is missing: blender, maya or command");
  if (std::find(kPrograms.begin(), kPrograms.end(), out.program) == kPrograms.end())
    throw RigError("external: no program '" + out.program + "'" +
                   solver::did_you_mean(out.program, kPrograms) + "; blender, maya or command");
  out.file = text_option(spec, "file");
  out.command = text_option(spec, "command");
  out.map = mapping_file(text_option(spec, "map"));
  const double servers = number_option(spec, "servers", 1, kMostServers, 1);
  out.servers = static_cast<int>(servers);
  if (servers != out.servers) throw RigError("external: option 'servers' must be a whole number");
  out.timeout = number_option(spec, "timeout", kLeastTimeout, kMostTimeout, out.timeout);
  check_options(spec, out);
  if (out.program == "command") split_command(out.command);
  return out;
}

std::vector<std::string> split_command(const std::string& command) {
  std::vector<std::string> words;
  std::string word;
  bool in_word = false;
  char quote = 0;
  for (std::size_t i = 0; i < command.size(); ++i) {
    const char c = command[i];
    if (quote != 0 && c == quote) {
      quote = 0;
    } else if (quote == 0 && (c == '\'' || c == '"')) {
      quote = c;
      in_word = true;
    } else if (c == '\\' && quote != '\'' && i + 1 < command.size()) {
      word += command[++i];
      in_word = true;
    } else if (quote == 0 && (c == ' ' || c == '\t' || c == '\n')) {
      if (in_word) words.push_back(std::move(word));
      word.clear();
      in_word = false;
    } else {
      word += c;
      in_word = true;
    }
  }
  if (quote != 0) throw RigError("command '" + command + "': a quote is not closed");
  if (in_word) words.push_back(std::move(word));
  if (words.empty()) throw RigError("command '" + command + "': names no program");
  return words;
}

std::vector<std::string> external_files(const solver::SystemSpec& spec) {
  const ExternalSpec external = external_spec(spec);
  if (external.program == kInProcess) return {};
  std::vector<std::string> files = {external.file, external.map};
  if (external.program == "command")
    for (std::string& word : split_command(external.command)) files.push_back(std::move(word));
  std::erase_if(files, [](const std::string& file) {
    std::error_code none;
    return file.empty() || !fs::is_regular_file(file, none);
  });
  return files;
}

std::string external_inputs(const solver::SystemSpec& spec) {
  std::string text;
  for (const std::string& file : external_files(spec)) text += content_hash(read_bytes(file)) + " ";
  return text;
}

}  // namespace backbend::validate
