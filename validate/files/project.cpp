#include "validate/files/project.h"

#include <toml++/toml.h>

#include <charconv>
#include <cmath>

#include "solver/rig/nearest_name.h"

namespace backbend::validate {
namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t kMostProjectBytes = std::uintmax_t{1} << 20;

class Reader {
 public:
  Reader(const fs::path& file, const ProjectKeys& keys) : keys_(keys) { project_.file = file; }

  Project read(const toml::table& root) {
    for (const auto& [name, node] : root) {
      const std::string key(name.str());
      // A name may be a command's and an option's, like `history`.
      if (const toml::table* table = node.as_table())
        read_table(key, *table, node);
      else
        read_value("", key, node);
    }
    return std::move(project_);
  }

 private:
  [[noreturn]] void fail(const toml::node& at, const std::string& why) const {
    throw ProjectError(project_.file.string() + ":" + std::to_string(at.source().begin.line) +
                       ": " + why);
  }

  const ProjectKind* key_at(const std::string& table, const std::string& key) const {
    const auto keys = keys_.find(table);
    if (keys == keys_.end()) return nullptr;
    const auto kind = keys->second.find(key);
    return kind == keys->second.end() ? nullptr : &kind->second;
  }

  void read_table(const std::string& name, const toml::table& table, const toml::node& at) {
    if (keys_.find(name) == keys_.end()) {
      std::vector<std::string> known;
      for (const auto& each : keys_)
        if (!each.first.empty()) known.push_back(each.first);
      fail(at, "[" + name + "]: not a command with project options" +
                   solver::did_you_mean(name, known));
    }
    for (const auto& [key, node] : table) read_value(name, std::string(key.str()), node);
  }

  void read_value(const std::string& table, const std::string& key, const toml::node& node) {
    const ProjectKind* kind = key_at(table, key);
    if (kind == nullptr) {
      std::vector<std::string> known;
      if (const auto keys = keys_.find(table); keys != keys_.end())
        for (const auto& each : keys->second) known.push_back(each.first);
      fail(node, "'" + key + "': not a project option" +
                     (table.empty() ? "" : " in [" + table + "]") +
                     solver::did_you_mean(key, known) + "; backbend config shows all");
    }
    project_.values[table][key] = {words_of(key, *kind, node), node.source().begin.line};
  }

  std::vector<std::string> words_of(const std::string& key, ProjectKind kind,
                                    const toml::node& node) const {
    switch (kind) {
      case ProjectKind::flag:
        if (const auto value = node.value_exact<bool>()) return {*value ? "true" : "false"};
        fail(node, "'" + key + "' must be true or false");
      case ProjectKind::number:
        if (const auto value = node.value_exact<std::int64_t>()) return {std::to_string(*value)};
        if (const auto value = node.value_exact<double>(); value && std::isfinite(*value)) {
          char text[32];
          return {{text, std::to_chars(text, text + sizeof text, *value).ptr}};
        }
        fail(node, "'" + key + "' must be a number");
      case ProjectKind::text:
        return {text_of(key, node, "text in quotes")};
      case ProjectKind::texts:
        break;
    }
    const toml::array* list = node.as_array();
    const std::string expected = "text in quotes, or a list of such";
    if (list == nullptr) return {text_of(key, node, expected)};
    std::vector<std::string> words;
    for (const toml::node& each : *list) words.push_back(text_of(key, each, expected));
    if (words.empty()) fail(node, "'" + key + "' must not be empty");
    return words;
  }

  std::string text_of(const std::string& key, const toml::node& node,
                      const std::string& expected) const {
    const auto value = node.value_exact<std::string>();
    if (!value) fail(node, "'" + key + "' must be " + expected);
    if (value->empty()) fail(node, "'" + key + "' must not be empty");
    // What the command line could not say either.
    if (value->find('\0') != std::string::npos) fail(node, "'" + key + "' holds a zero byte");
    return *value;
  }

  const ProjectKeys& keys_;
  Project project_;
};

}  // namespace

const ProjectValue* Project::find(const std::string& command, const std::string& option) const {
  for (const std::string& table : {command, std::string()}) {
    const auto found = values.find(table);
    if (found == values.end()) continue;
    if (const auto value = found->second.find(option); value != found->second.end())
      return &value->second;
  }
  return nullptr;
}

std::optional<fs::path> find_project(const fs::path& start) {
  std::error_code error;
  const fs::path whole = fs::absolute(start, error).lexically_normal();
  if (error) return std::nullopt;  // the working folder is gone
  fs::path folder =
      fs::weakly_canonical(fs::is_directory(whole, error) ? whole : whole.parent_path(), error);
  if (error) return std::nullopt;
  for (;; folder = folder.parent_path()) {
    const fs::path file = folder / kProjectFile;
    if (fs::is_regular_file(file, error)) return file;
    if (folder == folder.root_path() || folder.empty()) return std::nullopt;
  }
}

Project parse_project(std::string_view text, const fs::path& file, const ProjectKeys& keys) {
  try {
    return Reader(file, keys).read(toml::parse(text, file.string()));
  } catch (const toml::parse_error& error) {
    throw ProjectError(file.string() + ":" + std::to_string(error.source().begin.line) + ": " +
                       std::string(error.description()));
  }
}

Project read_project(const fs::path& file, const ProjectKeys& keys) {
  return parse_project(read_text(file, kMostProjectBytes), file, keys);
}

}  // namespace backbend::validate
