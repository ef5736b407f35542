#include "cli/settings.h"

#include <algorithm>
#include <cstdlib>
#include <map>

#include "validate/sweeps/suite.h"

namespace backbend::cli {
namespace {

namespace fs = std::filesystem;
using namespace backbend::validate;

/// Options that do not affect results.
constexpr const char* kGlobalOptions[] = {"threads", "quiet"};
/// Options that name what a command judges, after what stands on its line without a name.
constexpr const char* kJudged[] = {"--baked", "--character", "--suite", "--run"};

template <std::size_t N>
bool is_one_of(const std::string& name, const char* const (&names)[N]) {
  return std::find(std::begin(names), std::end(names), name) != std::end(names);
}

bool is_flag(const CLI::Option& option) { return option.get_items_expected_max() == 0; }

std::string type_of(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  return type.substr(0, type.find(':'));
}

ProjectKind kind_of(const CLI::Option& option) {
  if (is_flag(option)) return ProjectKind::flag;
  const std::string type = type_of(option);
  if (type == "INT" || type == "UINT" || type == "FLOAT") return ProjectKind::number;
  return option.get_items_expected_max() > 1 ? ProjectKind::texts : ProjectKind::text;
}

/// What --help says in brackets at the end.
std::string default_of(const CLI::Option& option) {
  if (is_flag(option) && !option.get_description().ends_with(']')) return "off";
  const std::string& text = option.get_description();
  const std::size_t open = text.rfind('[');
  if (!text.ends_with(']') || open == std::string::npos) return "none";
  return text.substr(open + 1, text.size() - open - 2);
}

std::string shown(const CLI::Option& option, const std::vector<std::string>& words) {
  if (is_flag(option)) return words.front() == "true" ? "on" : "off";
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ",") + word;
  return text;
}

std::string environment(const std::string& variable) {
  const char* value = std::getenv(variable.c_str());
  return value == nullptr ? "" : value;
}

/// A path of a project is relative to its file. One that was found, and may have come with
/// somebody's character, names nothing outside of its folder.
std::string from_project(const CLI::Option& option, const Project& project,
                         const ProjectValue& value, const std::string& word) {
  const std::string type = type_of(option);
  if (type != kFileType && !(type == kRigType && fs::path(word).extension() == ".toml"))
    return word;
  const fs::path folder = project.file.parent_path();
  const fs::path whole = (folder / word).lexically_normal();
  if (project.was_named) return whole.string();
  std::error_code none;
  const fs::path inside = fs::weakly_canonical(whole, none).lexically_relative(folder);
  if (none || inside.empty() || *inside.begin() == "..")
    throw ProjectError(project.file.string() + ":" + std::to_string(value.line) + ": '" +
                       key_of(option) +
                       "' leaves the project's folder; only a project that "
                       "--project names may do so");
  return whole.string();
}

/// The line's end of what the library says of a value: without the option's name, which is known.
std::string cause(const CLI::Option& option, const std::string& text) {
  const std::string name = option.get_name() + ": ";
  return text.starts_with(name) ? text.substr(name.size()) : text;
}

/// Gives an option its words as if the command line had said them. Throws CLI::ParseError, and
/// SuiteError for an unknown rig.
void say(CLI::Option& option, const std::vector<std::string>& words) {
  for (const std::string& word : words) option.add_result(word);
  option.run_callback();
  if (type_of(option) == kRigType)
    for (const std::string& word : words) read_rig(word);
}

void say_variable(CLI::Option& option, const Setting& setting) {
  try {
    if (is_flag(option) && setting.words.front() != "true" && setting.words.front() != "false")
      throw CLI::ValidationError("must be true or false");
    say(option, setting.words);
  } catch (const CLI::ParseError& error) {
    throw CLI::ValidationError(setting.place +
                               " in the environment: " + cause(option, error.what()));
  } catch (const SuiteError& error) {
    throw CLI::ValidationError(setting.place + " in the environment: " + error.what());
  }
}

void say_project(CLI::Option& option, const Setting& setting) {
  try {
    say(option, setting.words);
  } catch (const CLI::ParseError& error) {
    throw ProjectError(setting.place + ": '" + setting.option +
                       "': " + cause(option, error.what()));
  } catch (const SuiteError& error) {
    throw ProjectError(setting.place + ": " + error.what());
  }
}

/// A farm's job is a night: what [farm] does not say, [nightly] does.
const ProjectValue* given_by(const Project& project, const std::string& command,
                             const std::string& option) {
  const auto own = project.values.find(command);
  const bool says = own != project.values.end() && own->second.contains(option);
  return project.find(command == "farm" && !says ? "nightly" : command, option);
}

Setting take_setting(CLI::Option& option, const std::string& command, const Project* project) {
  Setting setting;
  setting.option = key_of(option);
  const std::string variable = variable_of(option);
  if (option.count() > 0) {
    setting.origin = Origin::command_line;
    setting.words = option.reduced_results();
  } else if (const std::string value = environment(variable); !value.empty()) {
    setting.origin = Origin::environment;
    setting.place = variable;
    setting.words = {value};
    say_variable(option, setting);
  } else if (const ProjectValue* given =
                 project == nullptr ? nullptr : given_by(*project, command, setting.option)) {
    setting.origin = Origin::project;
    setting.place = project->file.string() + ":" + std::to_string(given->line);
    for (const std::string& word : given->words)
      setting.words.push_back(from_project(option, *project, *given, word));
    say_project(option, setting);
  }
  setting.shown = setting.words.empty() ? default_of(option) : shown(option, setting.words);
  return setting;
}

/// What the options of the program itself say: no project, or which.
struct Asked {
  bool none = false;
  std::string file;
};

Asked asked_project(CLI::App& app) {
  Asked asked;
  asked.none = app.get_option("--no-project")->count() > 0;
  const CLI::Option& file = *app.get_option("--project");
  asked.file = file.count() > 0 ? file.as<std::string>() : environment("BACKBEND_PROJECT");
  return asked;
}

}  // namespace

std::string key_of(const CLI::Option& option) {
  const std::string name = option.get_name();
  return name.starts_with("--") ? name.substr(2) : name;
}

std::string variable_of(const CLI::Option& option) {
  std::string variable = "BACKBEND_";
  for (const char c : key_of(option))
    variable += c == '-' ? '_' : static_cast<char>(c >= 'a' && c <= 'z' ? c - 32 : c);
  return variable;
}

std::vector<CLI::Option*> settable_options(CLI::App& app) {
  return app.get_options([](const CLI::Option* option) { return option->get_configurable(); });
}

bool takes_settings(const CLI::App& command) {
  return command.get_name() != "completions" && command.get_name() != "list" &&
         command.get_name() != "config";
}

ProjectKeys project_keys(CLI::App& app) {
  ProjectKeys keys;
  for (const CLI::Option* option : settable_options(app))
    keys[""][key_of(*option)] = kind_of(*option);
  for (CLI::App* command : app.get_subcommands([](CLI::App*) { return true; })) {
    for (const CLI::Option* option : settable_options(*command))
      keys[command->get_name()][key_of(*option)] = keys[""][key_of(*option)] = kind_of(*option);
  }
  return keys;
}

std::optional<Project> project_at(CLI::App& app, const fs::path& file) {
  const Asked asked = asked_project(app);
  if (asked.none) return std::nullopt;
  if (!asked.file.empty()) {
    Project named = read_project(fs::absolute(asked.file), project_keys(app));
    named.was_named = true;
    return named;
  }
  const auto found = find_project(file.empty() ? fs::path(".") : file);
  return found ? std::optional(read_project(*found, project_keys(app))) : std::nullopt;
}

std::optional<Project> project_for(CLI::App& app, const CLI::App& command) {
  std::vector<const CLI::Option*> naming;
  for (const CLI::Option* option : command.get_options()) {
    // A word such as an engine's name is not a file, even where one of that name exists.
    const bool is_choice = option->get_type_name().find('{') != std::string::npos;
    if (option->get_positional() && !is_choice) naming.push_back(option);
  }
  for (const char* name : kJudged)
    if (const CLI::Option* option = command.get_option_no_throw(name)) naming.push_back(option);
  for (const CLI::Option* option : naming) {
    std::error_code none;
    for (const std::string& word : option->results())
      if (fs::exists(word, none)) return project_at(app, word);
  }
  return project_at(app, "");
}

std::vector<Setting> take_settings(CLI::App& app, CLI::App& command, const Project* project) {
  std::vector<Setting> settings;
  for (CLI::App* each : {&app, &command})
    for (CLI::Option* option : settable_options(*each))
      settings.push_back(take_setting(*option, command.get_name(), project));
  return settings;
}

std::string note_of(const std::vector<Setting>& settings) {
  std::map<std::string, std::string> names;  // by place
  for (const Setting& each : settings) {
    if (each.origin != Origin::project && each.origin != Origin::environment) continue;
    if (is_one_of(each.option, kGlobalOptions)) continue;
    // All of a project's lines in one.
    const std::string place =
        each.origin == Origin::project ? each.place.substr(0, each.place.rfind(':')) : each.place;
    std::string& list = names[place];
    list += (list.empty() ? "" : ", ") + each.option;
  }
  std::string note;
  for (const auto& [place, list] : names)
    note += (note.empty() ? "backbend: " : "; ") + list + " from " + place;
  return note;
}

}  // namespace backbend::cli
