#include <algorithm>
#include <cstdio>
#include <map>
#include <nlohmann/json.hpp>

#include "cli/nightly.h"
#include "cli/program.h"
#include "cli/settings.h"
#include "validate/text/escape.h"

namespace backbend::cli {
namespace {

namespace fs = std::filesystem;
using namespace backbend::validate;

constexpr const char* kShowOrigin = "--show-origin";

/// A setting, and the commands that have it with this value.
struct Row {
  Setting setting;
  std::vector<std::string> commands;
};

const char* name_of(Origin origin) {
  switch (origin) {
    case Origin::project:
      return "project";
    case Origin::environment:
      return "environment";
    case Origin::command_line:
      return "command line";
    default:
      return "default";
  }
}

std::string origin_text(const Setting& setting) {
  return setting.place.empty() ? name_of(setting.origin) : setting.place;
}

/// Adds what `command` takes; what earlier commands take alike shares their row.
void add_rows(std::vector<Row>& rows, const std::string& command,
              const std::vector<Setting>& settings) {
  for (const Setting& each : settings) {
    const auto same = std::find_if(rows.begin(), rows.end(), [&](const Row& row) {
      return row.setting.option == each.option && row.setting.shown == each.shown &&
             origin_text(row.setting) == origin_text(each);
    });
    if (same != rows.end()) {
      same->commands.push_back(command);
      continue;
    }
    // Beside the other values of the same option.
    const auto last = std::find_if(rows.rbegin(), rows.rend(), [&](const Row& row) {
      return row.setting.option == each.option;
    });
    rows.insert(last == rows.rend() ? rows.end() : last.base(), {each, {command}});
  }
}

void print_json(const std::vector<Row>& rows, const std::optional<Project>& project) {
  nlohmann::json list = nlohmann::json::array();
  for (const Row& row : rows) {
    const Setting& s = row.setting;
    std::vector<std::string> commands;
    for (const std::string& each : row.commands) commands.push_back(valid_utf8(each));
    nlohmann::json object = {{"option", s.option},
                             {"value", valid_utf8(s.shown)},
                             {"origin", name_of(s.origin)},
                             {"commands", commands}};
    if (s.origin == Origin::environment) object["variable"] = s.place;
    if (s.origin == Origin::project) {
      const std::size_t colon = s.place.rfind(':');
      object["file"] = valid_utf8(s.place.substr(0, colon));
      object["line"] = std::stoi(s.place.substr(colon + 1));
    }
    list.push_back(std::move(object));
  }
  nlohmann::json all = {{"schema", "backbend.config/1"}, {"settings", list}, {"project", nullptr}};
  if (project) all["project"] = valid_utf8(project->file.string());
  std::printf("%s\n", all.dump(2).c_str());
}

void print_text(const std::vector<Row>& rows, const std::optional<Project>& project,
                std::size_t command_count, bool show_origin) {
  std::printf("project  %s\n\n", project ? visible(project->file.string()).c_str() : "none");
  std::vector<std::vector<std::string>> table = {{"option", "value"}};
  if (show_origin) table.front().emplace_back("from");
  if (command_count > 1) table.front().emplace_back("commands");
  for (const Row& row : rows) {
    std::vector<std::string> line = {row.setting.option, visible(row.setting.shown)};
    if (show_origin) line.push_back(visible(origin_text(row.setting)));
    if (command_count > 1) {
      std::string list;
      for (const std::string& each : row.commands) list += (list.empty() ? "" : ", ") + each;
      line.push_back(row.commands.size() == command_count ? "all" : list);
    }
    table.push_back(std::move(line));
  }
  std::vector<std::size_t> width(table.front().size(), 0);
  for (const auto& line : table)
    for (std::size_t i = 0; i + 1 < line.size(); ++i)
      width[i] = std::max(width[i], line[i].size() + 2);
  for (const auto& line : table) {
    std::string text;
    for (std::size_t i = 0; i < line.size(); ++i) {
      text += line[i];
      if (i + 1 < line.size()) text.append(width[i] - line[i].size(), ' ');
    }
    std::printf("%s\n", text.c_str());
  }
}

struct ConfigOptions {
  std::string what;
  bool show_origin = false, json = false;
  CLI::App *app = nullptr, *command = nullptr;
};

/// The options of the program, the command, and all that follows it.
std::vector<std::string> words_of(const ConfigOptions& options) {
  std::vector<std::string> words = job_arguments(*options.app, "");
  words.push_back(options.what);
  // No command has an option of this name, so it may stand last.
  for (const std::string& word : options.command->remaining())
    if (word != kShowOrigin) words.push_back(word);
  return words;
}

int print_command_line(const ConfigOptions& options) {
  Program program;
  std::vector<std::string> words = words_of(options);
  program.app.parse(std::vector<std::string>(words.rbegin(), words.rend()));
  CLI::App& command = program.command();
  const auto project = project_for(program.app, command);
  std::vector<Row> rows;
  add_rows(rows, options.what, take_settings(program.app, command, project ? &*project : nullptr));
  if (options.json || program.common.json)
    print_json(rows, project);
  else
    print_text(rows, project, 1, options.show_origin);
  return 0;
}

int print_all(const ConfigOptions& options) {
  // What was said to all commands, before and after the word `config`; to one that takes nothing.
  std::vector<std::string> words = job_arguments(*options.app, "");
  for (const std::string& word : options.command->remaining()) words.push_back(word);
  words.insert(words.end(), {"completions", "man"});
  std::reverse(words.begin(), words.end());
  std::optional<Project> project;
  std::vector<Row> rows;
  std::size_t count = 0;
  for (const CLI::App* each : options.app->get_subcommands([](const CLI::App*) { return true; })) {
    if (!takes_settings(*each)) continue;
    // Of its own, for what is said to one command's options counts as said to those of all.
    Program program;
    program.app.parse(std::vector<std::string>(words));
    if (count++ == 0) project = project_at(program.app, options.what);
    CLI::App& command = *program.app.get_subcommand(each->get_name());
    add_rows(rows, each->get_name(),
             take_settings(program.app, command, project ? &*project : nullptr));
  }
  if (options.json)
    print_json(rows, project);
  else
    print_text(rows, project, count, options.show_origin);
  return 0;
}

int print_config(ConfigOptions options, const Common& common) {
  options.json = options.json || common.json;
  const auto is_command = [&](const CLI::App* each) { return each->get_name() == options.what; };
  if (!options.app->get_subcommands(is_command).empty()) {
    const std::vector<std::string> words = options.command->remaining();
    if (std::find(words.begin(), words.end(), kShowOrigin) != words.end())
      options.show_origin = true;
    return print_command_line(options);
  }
  std::error_code none;
  if (!options.what.empty() && !fs::exists(options.what, none))
    throw CLI::ValidationError("'" + options.what + "': not a command, and no such file");
  return print_all(options);
}

}  // namespace

void add_config(const Registry& registry) {
  auto options = std::make_shared<ConfigOptions>();
  options->app = &registry.app;
  CLI::App* command =
      registry.add("config", "show the value of every option, and where it comes from",
                   [options, &common = registry.common] { return print_config(*options, common); });
  options->command = command;
  command->add_option("what", options->what,
                      "a file to judge, or a whole command line, which is not run [the "
                      "working folder]");
  command->add_flag(kShowOrigin, options->show_origin,
                    "show the origin: default, project file and line, variable, command line");
  // Options of the command line that follows are its own.
  command->add_flag("--json", options->json, "one JSON object on standard output");
  command->fallthrough(false)->allow_extras()->prefix_command();
}

}  // namespace backbend::cli
