#include <fcntl.h>
#include <malloc.h>
#include <oneapi/tbb/global_control.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <exception>
#include <thread>

#include "cli/program.h"
#include "cli/settings.h"
#include "cli/trouble.h"
#include "cli/watch.h"
#include "skin/anatomy/facing.h"
#include "skin/anatomy/rig_templates.h"
#include "solver/rig/nearest_name.h"
#include "validate/text/escape.h"
#include "validate/verdicts/exit_code.h"

namespace backbend::cli {
namespace {

using namespace backbend::validate;

/// Results of the C library's mathematics are the same on every machine with AVX2 and FMA, which
/// is also what the program is compiled for.
bool machine_is_fit() { return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"); }

/// If the caller closed a standard stream, the next opened file would get its number, and output
/// would go into that file.
void fill_standard_streams() {
  int number = -1;
  do {
    number = ::open("/dev/null", O_RDWR);
  } while (number >= 0 && number <= STDERR_FILENO);
  if (number >= 0) ::close(number);
}

/// Layers of pictures come and go by the thousand. By default the C library gives them back to the
/// system each time, and every page of the next is made and cleared anew: a quarter of the time of
/// small pictures.
void keep_memory() {
  constexpr int kMegabyte = 1 << 20;
  ::mallopt(M_MMAP_THRESHOLD, 32 * kMegabyte);
  ::mallopt(M_TRIM_THRESHOLD, 256 * kMegabyte);
}

int complain(const std::string& line, ExitCode code) {
  // Names in messages come from files that anyone may have written.
  std::fprintf(stderr, "backbend: %s\n", visible(line).c_str());
  return code;
}

int run_guarded(const Run& run) {
  try {
    return run();
  } catch (...) {
    const Trouble trouble = trouble_of_exception();
    return complain(trouble.line, trouble.code);
  }
}

/// The command whose name is nearest to the line's first word, where that word is not a command.
/// Empty: it is one, or none is near.
std::string nearest_command(const CLI::App& app, int count, char** arguments) {
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands({})) names.push_back(command->get_name());
  for (int i = 1; i < count; ++i) {
    const std::string word = arguments[i];
    if (word.starts_with('-')) continue;
    if (std::ranges::find(names, word) != names.end()) return "";
    // The value of a global option may come before the command.
    if (const std::string before = arguments[i - 1];
        i > 1 && (before == "--threads" || before == "--project"))
      continue;
    return "no command '" + word + "'" + solver::did_you_mean(word, names);
  }
  return "";
}

/// A whole number that makes up all of `text`, or -1.
int whole_number(std::string_view text) {
  int value = -1;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc{} && end == text.data() + text.size() ? value : -1;
}

}  // namespace

std::pair<int, int> parse_resolution(const std::string& text) {
  const std::size_t cross = text.find('x');
  const int width =
      cross == std::string::npos ? -1 : whole_number(std::string_view(text).substr(0, cross));
  const int height =
      cross == std::string::npos ? -1 : whole_number(std::string_view(text).substr(cross + 1));
  if (width < 16 || height < 16 || width > 16384 || height > 16384) {
    throw CLI::ValidationError(
        "'" + text + "': invalid image size; expected WIDTHxHEIGHT, each 16 to 16384 pixels");
  }
  return {width, height};
}

std::string minutes_text(double minutes) {
  return minutes < 0.001 ? "0.001" : number_text(minutes, minutes < 0.1 ? 3 : minutes < 10 ? 1 : 0);
}

CLI::Validator picture_size() {
  return CLI::Validator(
      [](const std::string& text) {
        try {
          parse_resolution(text);
          return std::string();
        } catch (const CLI::ValidationError& error) {
          return std::string(error.what());
        }
      },
      "");
}

void add_anatomy_options(CLI::App* command, skin::AnatomyHints& hints) {
  std::string templates;
  for (const std::string_view name : skin::template_names())
    templates += (templates.empty() ? "" : ", ") + std::string(name);
  command->add_option("--template", hints.rig_template,
                      "naming convention of the joints: " + templates + " (automatic)");
  command->add_option("--hip", hints.hip, "joint at the hips (automatic)");
  command->add_option("--chest", hints.chest,
                      "last driven spine joint (automatic: where the arms hang)");
  command->add_option("--spine", hints.spine, "all spine joints, hips first, separated by commas")
      ->delimiter(',')
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  command->add_option("--left-arm", hints.left_arm, "left arm joints from the clavicle")
      ->delimiter(',')
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  command->add_option("--right-arm", hints.right_arm, "right arm joints from the clavicle")
      ->delimiter(',')
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  const CLI::IsMember axes(
      std::vector<std::string>(skin::kAxisNames.begin(), skin::kAxisNames.end()));
  command->add_option("--up", hints.up, "axis that is up, as +Y (automatic)")->check(axes);
  command
      ->add_option("--forward", hints.forward, "axis that the character faces, as -Z (automatic)")
      ->check(axes);
}

CLI::Option* add_mapping_option(CLI::App* command, std::string& mapping) {
  return command
      ->add_option("--mapping", mapping,
                   "how a body pose reaches the controls: chest or spread [chest]")
      ->check(CLI::IsMember({"chest", "spread"}));
}

void add_chain_option(CLI::App* command, std::string& chain) {
  command
      ->add_option("--chain", chain,
                   "what the rig drives: spine or neck [neck for the rig 'neck', else spine]")
      ->check(CLI::IsMember({"spine", "neck"}));
}

}  // namespace backbend::cli

int main(int argument_count, char** arguments) {
  using namespace backbend::cli;
  using backbend::validate::kExitOk;
  if (!machine_is_fit()) {
    return complain("this machine has no AVX2 and FMA, which the program needs", kExitInternal);
  }
  fill_standard_streams();
  keep_memory();
  watch_signals();

  Program program;
  try {
    program.app.parse(argument_count, arguments);
  } catch (const CLI::CallForHelp& call) {
    return program.app.exit(call);
  } catch (const CLI::CallForVersion& call) {
    return program.app.exit(call);
  } catch (const CLI::ParseError& error) {
    const std::string unknown = nearest_command(program.app, argument_count, arguments);
    return complain(
        (unknown.empty() ? std::string(error.what()) : unknown) + "; see backbend --help",
        kExitUsage);
  }
  const Common& common = program.common;
  const auto take = [&program] {
    take_surroundings(program);
    return kExitOk;
  };
  if (const int code = run_guarded(take); code != 0) return code;
  remember_command_line(argument_count, arguments);
  const oneapi::tbb::global_control limit(oneapi::tbb::global_control::max_allowed_parallelism,
                                          common.threads > 0
                                              ? static_cast<std::size_t>(common.threads)
                                              : std::max(1u, std::thread::hardware_concurrency()));
  return run_guarded(program.chosen);
}
