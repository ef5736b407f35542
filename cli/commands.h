#pragma once
#include <CLI/CLI.hpp>
#include <filesystem>
#include <functional>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "skin/anatomy/anatomy.h"
#include "validate/model/report.h"
#include "validate/report/terminal.h"
#include "validate/stage/stage.h"
#include "validate/sweeps/suite.h"
#include "validate/tasks/progress.h"

namespace backbend::cli {

/// Options that every command takes.
struct Common {
  bool quiet = false;
  bool json = false;
  int threads = 0;                     // 0: every core that the process may use
  std::set<std::string> from_project;  // options that a project file set, without dashes
  validate::Progress::Style progress_style() const {
    return quiet ? validate::Progress::Style::none : validate::Progress::Style::automatic;
  }
};

/// A command that was chosen on the command line: runs it and gives the exit code.
using Run = std::function<int()>;

/// Where a command registers itself: its callback puts its work into `chosen`.
struct Registry {
  CLI::App& app;
  Common& common;
  Run& chosen;

  CLI::App* add(const std::string& name, const std::string& summary, Run run) const {
    CLI::App* command = app.add_subcommand(name, summary);
    command->callback([&slot = chosen, run = std::move(run)] { slot = run; });
    return command;
  }
};

/// `--hip`, `--chest`, `--spine`, `--arms`: what a user knows of the skeleton.
void add_anatomy_options(CLI::App* command, skin::AnatomyHints& hints);

/// `--chain`: which chain the rig drives, `spine` or `neck`; empty: neck for the rig `neck`.
void add_chain_option(CLI::App* command, std::string& chain);

/// `--mapping`: `chest` or `spread`.
CLI::Option* add_mapping_option(CLI::App* command, std::string& mapping);

/// `640x480`. Throws CLI::ValidationError for anything else, or a side outside 16..16384.
std::pair<int, int> parse_resolution(const std::string& text);
/// Whether an option's value is such a size.
CLI::Validator picture_size();

/// An estimate for people: `0.02`, `3.5`, `21`; never 0.
std::string minutes_text(double minutes);

/// What standard output can show: width and colour of a terminal, plain text elsewhere.
validate::TerminalStyle style_of_stdout();

/// Today by the machine's own clock and place, `2026-11-22`.
std::string today();

/// `runs/DATE_TIME`, or what was asked for.
std::filesystem::path new_run_folder(const std::string& wanted);
/// What is judged, and how the character was understood: the first thing a user sees.
void print_character(const std::string& title, const validate::CharacterFacts& facts,
                     bool has_baseline = false);
/// Writes a report into its run folder (`is_latest`: the link beside it points there), prints it,
/// and gives its exit code.
int publish(const validate::Report& report, const std::filesystem::path& folder, bool is_latest,
            const Common& common, bool single_file = false);

/// `check --baked`: motion that another program solved.
struct BakedOptions {
  std::string clip, animation;
  std::vector<std::string> joint_map;  // CHARACTER_JOINT=CLIP_JOINT
  double frames_per_second = 24.0;
};
void add_baked_options(CLI::App* command, BakedOptions& options);
/// Judges the clip on a character (empty: its own body), and says first what it is. Pictures go
/// into `folder`; empty: none are made. Throws what run_clip() throws.
validate::Report baked_report(const BakedOptions& options, const std::string& character,
                              const skin::AnatomyHints& hints, const Common& common,
                              const std::filesystem::path& folder = {},
                              const validate::PicturePlan& pictures = {});
int check_baked(const BakedOptions& options, const std::string& character,
                const skin::AnatomyHints& hints, const std::string& output,
                const validate::PicturePlan& pictures, const Common& common);

void add_solve(const Registry& registry);
void add_inspect(const Registry& registry);
void add_check(const Registry& registry);
void add_merge(const Registry& registry);
void add_farm(const Registry& registry);
void add_completions(const Registry& registry);
void add_nightly(const Registry& registry);
void add_compare(const Registry& registry);
void add_render(const Registry& registry);
void add_turntable(const Registry& registry);
void add_body(const Registry& registry);
void add_bake(const Registry& registry);
void add_report(const Registry& registry);
void add_history(const Registry& registry);
void add_approve(const Registry& registry);
void add_prune(const Registry& registry);
void add_list(const Registry& registry);
void add_explain(const Registry& registry);
void add_bench(const Registry& registry);
void add_selftest(const Registry& registry);

}  // namespace backbend::cli
