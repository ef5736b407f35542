#include <sys/ioctl.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <ctime>

#include "cli/commands.h"
#include "validate/files/data_folder.h"
#include "validate/files/output_folder.h"
#include "validate/report/escape.h"
#include "validate/report/report_json.h"
#include "validate/report/terminal.h"
#include "validate/run/run.h"
#include "validate/sweeps/suite.h"

namespace backbend::cli {
namespace {

namespace fs = std::filesystem;
using namespace backbend::validate;

/// What nightly, check and compare have in common on the command line.
struct RunOptions {
  std::string output;
  bool quick = false;
  std::string resolution;
  int samples = 0;
  bool single_file = false;
  std::string baseline, history, label;
  skin::AnatomyHints hints;

  void add_to(CLI::App* command) {
    command->add_option("-o,--output", output, "run folder [runs/DATE_TIME with a link 'latest']");
    command->add_flag("--quick", quick, "measure only: no pictures");
    command->add_option("--res", resolution, "picture size, WIDTHxHEIGHT pixels [640x480]");
    command->add_option("--spp", samples, "samples a pixel of the pictures [16]")
        ->check(CLI::Range(1, 65536));
    command->add_flag("--single-file", single_file, "every picture inside the page");
    command->add_option("--baseline", baseline,
                        "approved failures (backbend approve): only new or worse ones fail");
    command->add_option("--history", history,
                        "history to add this night to, for trends [nightly: runs/history.jsonl]");
    command->add_option("--label", label, "what this version is called in the history, like v013");
    add_anatomy_options(command, hints);
  }

  void apply_to(RunRequest& request) const {
    request.hints = hints;
    if (quick) {
      request.suite.pictures.enabled = false;
      request.image_pass = false;
    }
    if (samples > 0) request.suite.pictures.samples = samples;
    if (!resolution.empty()) {
      const auto [width, height] = parse_resolution(resolution);
      request.suite.pictures.width = width;
      request.suite.pictures.height = height;
    }
    request.today = today();
    request.label = label;
    // Read before the work, so that what is damaged is said now and not in the morning.
    if (!history.empty()) request.history = read_history(history);
    if (!baseline.empty()) {
      if (!fs::exists(baseline))
        throw NoBaseline(baseline + ": no such baseline; backbend approve makes one");
      request.baseline = parse_baseline(read_text(baseline), baseline);
      if (request.baseline->suite != request.suite.name)
        throw BaselineError(baseline + ": this baseline is of suite '" + request.baseline->suite +
                            "', not of '" + request.suite.name + "'");
    }
  }
};

}  // namespace

/// runs/2026-11-21_093100: local time, because people look for "this morning's run".
fs::path new_run_folder(const std::string& wanted) {
  if (!wanted.empty()) return wanted;
  const std::time_t now = std::time(nullptr);
  std::tm local = {};
  localtime_r(&now, &local);
  char name[80];
  std::snprintf(name, sizeof name, "%04d-%02d-%02d_%02d%02d%02d", local.tm_year + 1900,
                local.tm_mon + 1, local.tm_mday, local.tm_hour, local.tm_min, local.tm_sec);
  fs::path folder = fs::path("runs") / name;
  for (int again = 2; fs::exists(folder); ++again)
    folder = fs::path("runs") / (std::string(name) + "-" + std::to_string(again));
  return folder;
}

namespace {

/// Joint names from the hips up; of a chain that would fill the screen (a snake's) the two ends.
std::string chain_text(const std::vector<std::string>& joints) {
  constexpr std::size_t kMost = 24, kStart = 6, kEnd = 3;
  std::string text;
  for (std::size_t i = 0; i < joints.size(); ++i) {
    if (joints.size() > kMost && i == kStart) {
      text += " > (" + std::to_string(joints.size() - kStart - kEnd) + " more)";
      i = joints.size() - kEnd;
    }
    text += (text.empty() ? "" : " > ") + visible(joints[i]);
  }
  return text.empty() ? "none found" : text;
}

}  // namespace

void print_character(const std::string& title, const CharacterFacts& facts, bool has_baseline) {
  const std::string sure =
      facts.sure ? "   sure" : "   not sure: --hip, --chest and --spine settle it";
  std::printf("%s\n", visible(title).c_str());
  std::printf(
      "  body   %d part%s, %d vertices, %s high, spine %s long (file units; the reference "
      "length)\n",
      facts.meshes, facts.meshes == 1 ? "" : "s", facts.vertices,
      number_text(facts.height, 3).c_str(), number_text(facts.spine_length, 3).c_str());
  std::printf("  spine  %s%s\n", chain_text(facts.spine).c_str(), sure.c_str());
  const std::string left = facts.left_arm.empty() ? "none" : visible(facts.left_arm.front());
  const std::string right = facts.right_arm.empty() ? "none" : visible(facts.right_arm.front());
  std::printf("  arms   %s, %s\n", left.c_str(), right.c_str());
  for (const std::string& note : facts.notes) std::printf("  note   %s\n", visible(note).c_str());
  std::printf("  limits envelope '%s', %s\n\n", facts.envelope.c_str(),
              has_baseline ? "baseline: new or worse fails" : "no baseline: absolute limits");
  std::fflush(stdout);
}

int publish(const Report& report, const fs::path& folder, bool is_latest, const Common& common,
            bool single_file) {
  write_report(report, folder, {{}, single_file});
  if (is_latest) point_link(folder.parent_path() / "latest", folder.filename());
  if (common.json) {
    std::printf("%s\n", report_json(report).c_str());
  } else {
    TerminalStyle style = style_of_stdout();
    style.page = (folder / "index.html").string();
    std::printf("%s", terminal_summary(report, style).c_str());
  }
  return report.exit_code;
}

namespace {

int run_and_print(RunRequest request, const Common& common, const RunOptions& options) {
  if (!common.json) {
    request.on_character = [&request](const CharacterFacts& facts) {
      print_character(request.title.empty() ? request.suite.title : request.title, facts,
                      request.baseline.has_value());
    };
  }
  request.folder = new_run_folder(options.output);
  Progress progress(common.progress_style());
  const Report report = run_suite(request, progress);
  progress.finish();
  const int code =
      publish(report, request.folder, options.output.empty(), common, options.single_file);
  if (!options.history.empty())
    append_night(options.history, night_of(report, request.today, request.label));
  return code;
}

/// The rig of a comparison that must be caught, as in every run (specification 8, canaries).
RigPlan isner_canary() {
  RigPlan plan;
  plan.name = "isner_flip";
  plan.spec.system = "isner";
  plan.role = Role::canary;
  CanaryDuty duty;
  duty.code = "BB001";
  duty.sweep = "extension";
  duty.joint = "top_vertebra";
  duty.control_deg = 114.3;
  duty.tolerance_deg = 0.3;
  duty.twin.system = "matrix_blend";
  plan.duty = duty;
  return plan;
}

std::vector<Sweep> sweeps_named(const std::string& name) {
  return name == "stress" ? stress_sweeps() : standard_sweeps();
}

}  // namespace

/// What standard output can show: width and colour of a terminal, plain text elsewhere.
TerminalStyle style_of_stdout() {
  TerminalStyle style;
  const char* no_color = std::getenv("NO_COLOR");
  const char* terminal = std::getenv("TERM");
  winsize size = {};
  if (isatty(STDOUT_FILENO) == 1) {
    if (ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0) style.width = size.ws_col;
    style.color = (no_color == nullptr || *no_color == '\0') && terminal != nullptr &&
                  std::string_view(terminal) != "dumb";
  }
  style.unicode = false;
  return style;
}

void add_nightly(const Registry& registry) {
  struct Options : RunOptions {
    std::string suite, character;
  };
  auto options = std::make_shared<Options>();
  CLI::App* command = registry.add(
      "nightly", "run a suite: the nightly comparison of rigs, with its report",
      [options, &common = registry.common] {
        RunRequest request;
        const fs::path file = options->suite.empty() ? data_folder() / "scenes" / "nightly.toml"
                                                     : fs::path(options->suite);
        request.suite = read_suite(file);
        if (!options->character.empty()) request.suite.characters = {options->character};
        // A night without a folder of its own is one of many: it belongs to their history.
        if (options->history.empty() && options->output.empty())
          options->history = "runs/history.jsonl";
        options->apply_to(request);
        request.character = options->character;
        return run_and_print(std::move(request), common, *options);
      });
  command->add_option("suite", options->suite, "suite file [the bundled scenes/nightly.toml]");
  command->add_option("--character", options->character,
                      "character file in place of the suite's own");
  options->add_to(command);
}

void add_check(const Registry& registry) {
  struct Options : RunOptions {
    std::string character, rig = "even", mapping = "chest", envelope = "human", sweeps = "standard",
                           chain;
    BakedOptions baked;
  };
  auto options = std::make_shared<Options>();
  CLI::App* command = registry.add(
      "check", "judge one character under a rig, or the motion of its own rig",
      [options, &common = registry.common] {
        if (!options->baked.clip.empty())
          return check_baked(options->baked, options->character, options->hints, options->output,
                             common);
        if (options->character.empty())
          throw CLI::RequiredError("a character file, or --baked with a clip");
        RunRequest request;
        Suite& suite = request.suite;
        suite.name = "check";
        suite.characters = {options->character};
        suite.rigs = {read_rig(options->rig), isner_canary()};
        suite.mappings = {*find_mapping(options->mapping)};
        suite.sweeps = sweeps_named(options->sweeps);
        suite.envelope = *find_envelope(options->envelope);
        suite.pictures.sheet_columns = 0;
        options->apply_to(request);
        request.chain = driven_chain(options->chain, suite.rigs.front(), options->hints);
        request.title = "Judging WEIGHTS of " + fs::path(options->character).filename().string() +
                        " under rig '" + suite.rigs.front().name + "'";
        request.character = options->character;
        suite.judges_weights = true;
        return run_and_print(std::move(request), common, *options);
      });
  command->add_option("character", options->character,
                      "character file: .glb, .gltf, or a body description .toml");
  add_baked_options(command, options->baked);
  command->add_option("--rig", options->rig,
                      "rig: a system (backbend list rigs) or a rig file [even]");
  command
      ->add_option("--mapping", options->mapping,
                   "how a body pose reaches the controls: chest or spread [chest]")
      ->check(CLI::IsMember({"chest", "spread"}));
  command
      ->add_option("--envelope", options->envelope,
                   "what the character must do: human, cartoon, creature or sweep [human]")
      ->check(CLI::IsMember(envelope_names()));
  add_chain_option(command, options->chain);
  command->add_option("--sweeps", options->sweeps, "standard or stress [standard]")
      ->check(CLI::IsMember({"standard", "stress"}));
  options->add_to(command);
}

void add_compare(const Registry& registry) {
  struct Options : RunOptions {
    std::string first, second, character, mapping = "chest", sweeps = "stress";
  };
  auto options = std::make_shared<Options>();
  CLI::App* command = registry.add(
      "compare", "two rigs on the same character and the same poses",
      [options, &common = registry.common] {
        RunRequest request;
        Suite& suite = request.suite;
        suite.name = "compare";
        suite.rigs = {read_rig(options->first), read_rig(options->second), isner_canary()};
        suite.rigs[1].role = Role::reference;
        if (suite.rigs[0].name == suite.rigs[1].name) suite.rigs[1].name += "_2";
        suite.title = suite.rigs[0].name + " against " + suite.rigs[1].name;
        const fs::path bundled =
            read_suite(data_folder() / "scenes" / "nightly.toml").characters.front();
        suite.characters = {options->character.empty() ? bundled : fs::path(options->character)};
        suite.mappings = {*find_mapping(options->mapping)};
        suite.sweeps = sweeps_named(options->sweeps);
        suite.envelope = *find_envelope("sweep");
        options->apply_to(request);
        request.character =
            options->character.empty() ? "scenes/characters/human.toml" : options->character;
        return run_and_print(std::move(request), common, *options);
      });
  command->add_option("A", options->first, "the proposed rig: a system or a rig file")->required();
  command->add_option("B", options->second, "the rig to compare with")->required();
  command->add_option("--character", options->character, "character file [the bundled human]");
  command->add_option("--mapping", options->mapping, "chest or spread [chest]")
      ->check(CLI::IsMember({"chest", "spread"}));
  command->add_option("--sweeps", options->sweeps, "standard or stress [stress]")
      ->check(CLI::IsMember({"standard", "stress"}));
  options->add_to(command);
}

}  // namespace backbend::cli
