#pragma once
#include <string>
#include <vector>

#include "cli/commands.h"
#include "validate/night/run.h"

namespace backbend::cli {

/// Options common to nightly, check and compare.
struct RunOptions {
  std::string output;
  bool quick = false;
  std::string resolution;
  int samples = 0;
  bool single_file = false;
  std::string baseline, history, label;
  skin::AnatomyHints hints;

  void add_to(CLI::App* command);
  /// `--quick`, `--res`, `--spp`.
  void apply_to(validate::PicturePlan& pictures) const;
  /// Reads history and baseline, too. Throws what their readers throw.
  void apply_to(validate::RunRequest& request) const;
};

/// What says which night it is. A job that is cut into shards is rebuilt from the same options.
struct NightlyOptions : RunOptions {
  std::string suite, character;
  double hunt_percent = -1.0;  // below 0: not given

  void add_to(CLI::App* command);
  /// Throws SuiteError and what apply_to() throws.
  validate::RunRequest request() const;
};

/// Runs a request, writes its report into its run folder, prints it and adds the night to the
/// history that was asked for; gives the exit code.
int run_and_print(validate::RunRequest request, const Common& common, const RunOptions& options);

/// `--dry-run`: prints the plan and the estimated time.
int print_estimate(const validate::RunRequest& request, const Common& common);

/// The words of a command line that say what a job is: the options that were given, then the suite
/// with its whole path. How it is done (folder, shard) is left out; files that only the report
/// needs have their whole path.
std::vector<std::string> job_arguments(const CLI::App& command, const std::string& suite);
/// Those of them that results depend on: neither the suite's name nor what only the report needs.
std::vector<std::string> stamped_words(const std::vector<std::string>& arguments);
/// The inverse of job_arguments(). Throws CLI::ParseError.
NightlyOptions nightly_options(const std::vector<std::string>& arguments);

/// Merges the shards of one job in `runs` into `output` (empty: the first of them), writes its
/// report and prints it. Throws MixedPartsError, IncompleteError, ReadError.
int merge_runs(const std::vector<std::string>& runs, const std::string& output,
               const Common& common);

}  // namespace backbend::cli
