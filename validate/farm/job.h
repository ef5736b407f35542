#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "validate/night/run.h"

namespace backbend::validate {

/// A job in shards: its command line and its inputs.
struct JobPlan {
  std::vector<std::string> arguments;  // of `nightly`, the suite's path absolute
  std::filesystem::path folder;        // working folder that relative paths started from
  std::string stamp;
};

/// Hashes everything that the results of a run depend on: the program, the suite, the contents of
/// its rigs and characters, and the options. Throws ReadError.
std::string job_stamp(const RunRequest& request, const std::vector<std::string>& options);

/// Writes the plan below the run folder, or finds the same one there. Throws MixedPartsError where
/// the folder holds parts of another job, WriteError.
void keep_plan(const JobPlan& plan, const std::filesystem::path& run);
/// Throws ReadError where there is none, or none that can be read.
JobPlan read_plan(const std::filesystem::path& run);

/// The size of a job and its estimated time on this machine, from one pose and one picture.
struct JobEstimate {
  std::size_t characters = 0, rigs = 0, mappings = 0, sweeps = 0, canaries = 0;
  std::size_t poses = 0;           // measured, over everything
  std::size_t searched = 0;        // of the search between the sweeps, at most
  std::size_t small_pictures = 0;  // looked at by image metrics
  std::size_t pictures = 0;        // rendered for people, at most
  double minutes = 0;
};
JobEstimate estimate(const RunRequest& request);

/// The scripts that do a job elsewhere: file name and content.
struct FarmScripts {
  std::vector<std::pair<std::string, std::string>> files;
  std::string start;  // the one to start
};
/// What scripts must know.
struct FarmJob {
  std::string program;                 // absolute
  std::filesystem::path folder, run;   // working and run folder, absolute
  std::vector<std::string> arguments;  // of `nightly`
  int shards = 8;
};
FarmScripts slurm_scripts(const FarmJob& job);
FarmScripts parallel_scripts(const FarmJob& job);
FarmScripts openjd_scripts(const FarmJob& job);

}  // namespace backbend::validate
