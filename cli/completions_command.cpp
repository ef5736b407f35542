#include <algorithm>
#include <cstdio>
#include <map>

#include "cli/commands.h"
#include "cli/settings.h"
#include "validate/text/joined.h"
#include "validate/text/shell_word.h"

namespace backbend::cli {
namespace {

using validate::joined;
using validate::shell_quoted;

/// An option as every form shows it.
struct Word {
  std::vector<std::string> names;  // -o, --output
  std::string help;
  std::vector<std::string> choices;
  bool takes_value = false;
  std::string variable;  // of the environment; empty: none
};

struct Command {
  std::string name, help;
  std::vector<Word> options;
  std::vector<Word> positionals;
};

/// The words of `{a,b,c}` or `{a->0,b->1}`, as the library describes a check by IsMember and names
/// of an enum's values. None where it is one of several checks, for other words are taken too.
std::vector<std::string> choices_of(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  const std::size_t open = type.find('{'), close = type.find('}');
  std::vector<std::string> choices;
  if (open == std::string::npos || close == std::string::npos) return choices;
  if (type.find(" OR ") != std::string::npos && type.find("->") == std::string::npos)
    return choices;
  std::string word;
  for (const char c : type.substr(open + 1, close - open - 1) + ",") {
    if (c == ',') {
      word = word.substr(0, word.find("->"));
      if (!word.empty()) choices.push_back(word);
      word.clear();
    } else {
      word += c;
    }
  }
  return choices;
}

Word word_of(const CLI::Option& option) {
  Word word;
  for (const std::string& name : option.get_snames()) word.names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) word.names.push_back("--" + name);
  if (word.names.empty()) word.names.push_back(option.get_name());
  word.help = option.get_description();
  word.choices = choices_of(option);
  word.takes_value = option.get_items_expected_max() > 0;
  if (option.get_configurable()) word.variable = variable_of(option);
  return word;
}

Command command_of(const CLI::App& app) {
  Command command{app.get_name(), app.get_description(), {}, {}};
  for (const CLI::Option* option : app.get_options()) {
    (option->get_positional() ? command.positionals : command.options).push_back(word_of(*option));
  }
  return command;
}

/// The program first, then its commands.
std::vector<Command> commands_of(const CLI::App& app) {
  std::vector<Command> commands = {command_of(app)};
  for (const CLI::App* each : app.get_subcommands([](const CLI::App*) { return true; }))
    commands.push_back(command_of(*each));
  return commands;
}

std::vector<std::string> option_names(const Command& command) {
  std::vector<std::string> names;
  for (const Word& word : command.options)
    names.insert(names.end(), word.names.begin(), word.names.end());
  return names;
}

std::vector<std::string> command_names(const std::vector<Command>& commands) {
  std::vector<std::string> names;
  for (std::size_t i = 1; i < commands.size(); ++i) names.push_back(commands[i].name);
  return names;
}

std::string bash_text(const std::vector<Command>& commands) {
  std::string text =
      "# bash completion for backbend\n"
      "_backbend() {\n"
      "  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} command= "
      "options=\n"
      "  local each\n"
      "  COMPREPLY=()\n"
      "  for each in \"${COMP_WORDS[@]:1:COMP_CWORD-1}\"; do\n"
      "    case $each in\n"
      "      " +
      joined(command_names(commands), "|") +
      ") command=$each; break ;;\n"
      "    esac\n"
      "  done\n"
      "  case \"$command $before\" in\n";
  for (const Command& command : commands) {
    const std::string name = &command == &commands.front() ? "" : command.name;
    for (const Word& word : command.options) {
      if (word.choices.empty()) continue;
      std::string patterns;
      for (const std::string& option : word.names)
        patterns += (patterns.empty() ? "'" : "|'") + name + " " + option + "'";
      text += "    " + patterns + ") COMPREPLY=($(compgen -W '" + joined(word.choices, " ") +
              "' -- \"$word\")); return ;;\n";
    }
  }
  text += "  esac\n  case $command in\n";
  for (const Command& command : commands) {
    std::vector<std::string> words = option_names(command);
    const bool is_program = &command == &commands.front();
    if (is_program) {
      for (const std::string& name : command_names(commands)) words.push_back(name);
    } else {
      for (const std::string& name : option_names(commands.front())) words.push_back(name);
      for (const Word& positional : command.positionals)
        words.insert(words.end(), positional.choices.begin(), positional.choices.end());
    }
    std::sort(words.begin(), words.end());
    words.erase(std::unique(words.begin(), words.end()), words.end());
    text += "    " + (is_program ? std::string("''") : command.name) + ") options='" +
            joined(words, " ") + "' ;;\n";
  }
  return text +
         "  esac\n"
         "  if [[ $word == -* || -z $command ]]; then\n"
         "    COMPREPLY=($(compgen -W \"$options\" -- \"$word\"))\n"
         "  else\n"
         "    COMPREPLY=($(compgen -W \"$options\" -- \"$word\") $(compgen -f -- \"$word\"))\n"
         "  fi\n"
         "}\n"
         "complete -o filenames -F _backbend backbend\n";
}

/// A help line inside a zsh specification: brackets and colons have a meaning there.
std::string zsh_help(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (c == '[' || c == ']' || c == ':' || c == '\\') result += '\\';
    result += c;
  }
  return result;
}

std::string zsh_text(const std::vector<Command>& commands) {
  std::string text =
      "#compdef backbend\n"
      "_backbend() {\n"
      "  local context state line\n"
      "  typeset -A opt_args\n"
      "  local -a commands\n"
      "  commands=(\n";
  for (std::size_t i = 1; i < commands.size(); ++i)
    text += "    " + shell_quoted(commands[i].name + ":" + zsh_help(commands[i].help)) + "\n";
  text += "  )\n";
  const auto specifications = [](const Command& command) {
    std::string lines;
    for (const Word& word : command.options) {
      for (const std::string& name : word.names) {
        std::string value;
        if (!word.choices.empty())
          value = ":value:(" + joined(word.choices, " ") + ")";
        else if (word.takes_value)
          value = ":value:_files";
        lines += " \\\n        " + shell_quoted(name + "[" + zsh_help(word.help) + "]" + value);
      }
    }
    return lines;
  };
  text += "  _arguments -C" + specifications(commands.front()) +
          " \\\n        '1:command:->command' '*::argument:->argument'\n"
          "  case $state in\n"
          "    command) _describe command commands ;;\n"
          "    argument)\n"
          "      case $line[1] in\n";
  for (std::size_t i = 1; i < commands.size(); ++i) {
    text += "        " + commands[i].name + ") _arguments" + specifications(commands[i]);
    for (const Word& positional : commands[i].positionals) {
      if (!positional.choices.empty())
        text += " \\\n        " + shell_quoted("1:" + positional.names.front() + ":(" +
                                               joined(positional.choices, " ") + ")");
    }
    text += " \\\n        '*:file:_files' ;;\n";
  }
  return text + "      esac ;;\n  esac\n}\n_backbend \"$@\"\n";
}

std::string fish_text(const std::vector<Command>& commands) {
  std::string text = "# fish completion for backbend\n";
  const std::string none =
      "not __fish_seen_subcommand_from " + joined(command_names(commands), " ");
  for (const Command& command : commands) {
    const bool is_program = &command == &commands.front();
    const std::string when =
        is_program ? "" : " -n " + shell_quoted("__fish_seen_subcommand_from " + command.name);
    if (!is_program)
      text += "complete -c backbend -f -n " + shell_quoted(none) + " -a " + command.name + " -d " +
              shell_quoted(command.help) + "\n";
    for (const Word& word : command.options) {
      text += "complete -c backbend" + when;
      for (const std::string& name : word.names)
        text += name.rfind("--", 0) == 0 ? " -l " + name.substr(2) : " -s " + name.substr(1);
      if (word.takes_value) text += " -r";
      if (!word.choices.empty()) text += " -f -a " + shell_quoted(joined(word.choices, " "));
      text += " -d " + shell_quoted(word.help) + "\n";
    }
    for (const Word& positional : command.positionals) {
      if (!positional.choices.empty())
        text += "complete -c backbend" + when + " -f -a " +
                shell_quoted(joined(positional.choices, " ")) + "\n";
    }
  }
  return text;
}

/// Text as roff takes it literally.
std::string roff(const std::string& text) {
  std::string result = !text.empty() && (text[0] == '.' || text[0] == '\'') ? "\\&" : "";
  for (const char c : text) {
    if (c == '\\')
      result += "\\e";
    else if (c == '-')
      result += "\\-";
    else
      result += c;
  }
  return result;
}

std::string man_options(const Command& command) {
  std::string text;
  for (const Word& word : command.options) {
    std::string names;
    for (const std::string& name : word.names)
      names += (names.empty() ? "\\fB" : ", \\fB") + roff(name) + "\\fR";
    text += ".TP\n" + names;
    if (word.takes_value)
      text += word.choices.empty() ? " \\fIVALUE\\fR"
                                   : " \\fI" + roff(joined(word.choices, "|")) + "\\fR";
    text += "\n" + roff(word.help) + "\n";
  }
  return text;
}

/// Every variable with the options that it sets, by the commands that have them.
std::string man_environment(const std::vector<Command>& commands) {
  std::map<std::string, std::string> options;  // by variable
  for (const Command& command : commands) {
    for (const std::vector<Word>* words : {&command.positionals, &command.options}) {
      for (const Word& word : *words) {
        if (word.variable.empty()) continue;
        std::string& text = options[word.variable];
        if (text.empty())
          text = (word.names.back().starts_with("-") ? "" : "the ") + word.names.back() + " of ";
        else
          text += ", ";
        text += &command == &commands.front() ? "every command" : command.name;
      }
    }
  }
  std::string text;
  for (const auto& [variable, what] : options)
    text += ".TP\n\\fB" + roff(variable) + "\\fR\n" + roff(what) + "\n";
  return text;
}

std::string man_text(const std::vector<Command>& commands) {
  std::string text = ".TH BACKBEND 1 \"\" \"backbend " BACKBEND_VERSION
                     "\" \"User Commands\"\n"
                     ".SH NAME\n"
                     "backbend \\- find out whether a character's spine rig can be trusted\n"
                     ".SH SYNOPSIS\n"
                     ".B backbend\n"
                     "[\\fIOPTIONS\\fR] \\fICOMMAND\\fR [\\fIARGUMENTS\\fR]\n"
                     ".SH DESCRIPTION\n" +
                     roff(commands.front().help) + "\n.SH OPTIONS\nEvery command takes these.\n" +
                     man_options(commands.front()) + ".SH COMMANDS\n";
  for (std::size_t i = 1; i < commands.size(); ++i) {
    const Command& command = commands[i];
    text += ".SS \"" + roff(command.name);
    for (const Word& positional : command.positionals) text += " " + roff(positional.names.front());
    text += "\"\n" + roff(command.help) + "\n";
    for (const Word& positional : command.positionals)
      text +=
          ".TP\n\\fI" + roff(positional.names.front()) + "\\fR\n" + roff(positional.help) + "\n";
    text += man_options(command);
  }
  return text +
         ".SH FILES\n"
         ".TP\n\\fIbackbend.toml\\fR\n"
         "A project's defaults for options: the nearest one in the folder of the judged file or "
         "above it. Keys are options' names without dashes, tables are commands; paths are "
         "relative to it. The command line counts before the environment, that before the project, "
         "that before defaults; \\fBbackbend config \\-\\-show\\-origin\\fR shows where "
         "each value comes from.\n"
         ".SH ENVIRONMENT\n"
         "An empty variable counts as none; a flag's is true or false.\n"
         ".TP\n\\fBBACKBEND_PROJECT\\fR\nthe project file to take, as \\-\\-project\n"
         ".TP\n\\fBNO_COLOR\\fR\nno colours on a terminal\n" +
         man_environment(commands) +
         ".SH EXIT STATUS\n"
         "0 everything measured and within limits; 1 findings over a limit; 2 usage; 3 bad input; "
         "4 incomplete: parts are missing; 5 something was not measured; 6 no baseline where one "
         "was "
         "required; 70 internal error; 73 cannot write; 75 temporary, try again; 130 interrupted; "
         "143 terminated.\n";
}

}  // namespace

void add_completions(const Registry& registry) {
  auto shell = std::make_shared<std::string>();
  CLI::App* command = registry.add(
      "completions", "print shell completions or the manual page", [shell, &app = registry.app] {
        const std::vector<Command> commands = commands_of(app);
        const std::string text = *shell == "bash"   ? bash_text(commands)
                                 : *shell == "zsh"  ? zsh_text(commands)
                                 : *shell == "fish" ? fish_text(commands)
                                                    : man_text(commands);
        std::fputs(text.c_str(), stdout);
        return 0;
      });
  command->add_option("form", *shell, "bash, zsh, fish or man")
      ->required()
      ->check(CLI::IsMember({"bash", "zsh", "fish", "man"}));
}

}  // namespace backbend::cli
