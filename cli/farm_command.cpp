#include <sys/stat.h>

#include <cstdio>

#include "cli/nightly.h"
#include "validate/farm/job.h"
#include "validate/files/child_process.h"
#include "validate/files/output_folder.h"
#include "validate/text/escape.h"

namespace backbend::cli {

namespace fs = std::filesystem;
using namespace backbend::validate;

void add_merge(const Registry& registry) {
  struct Options {
    std::vector<std::string> runs;
    std::string output;
  };
  auto options = std::make_shared<Options>();
  CLI::App* command = registry.add("merge", "merge the shards of a night and write its report",
                                   [options, &common = registry.common] {
                                     return merge_runs(options->runs, options->output, common);
                                   });
  command->add_option("runs", options->runs, "run folders of the shards")
      ->required()
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  command->add_option("-o,--output", options->output,
                      "run folder of the merged report [the first one]");
}

void add_farm(const Registry& registry) {
  struct Options : NightlyOptions {
    std::string engine;
    int shards = 8;
    bool submit = false;
    CLI::App* command = nullptr;
  };
  auto options = std::make_shared<Options>();
  CLI::App* command =
      registry.add("farm", "write scripts that run a night on a farm, in shards", [options] {
        if (options->output.empty())
          throw CLI::RequiredError("-o DIR, the run folder that every shard can reach");
        if (options->submit && options->engine == "openjd")
          throw CLI::ValidationError(
              "--submit: not available for openjd; submit the template with the farm's own tools");
        FarmJob job;
        job.program = fs::read_symlink("/proc/self/exe").string();
        job.folder = fs::current_path();
        job.run = fs::absolute(options->output).lexically_normal();
        job.arguments = job_arguments(*options->command, options->suite);
        job.shards = options->shards;
        options->request();  // what cannot be run is said now, not on the farm
        const FarmScripts scripts = options->engine == "slurm"      ? slurm_scripts(job)
                                    : options->engine == "parallel" ? parallel_scripts(job)
                                                                    : openjd_scripts(job);
        const fs::path folder = job.run / "farm";
        for (const auto& [name, text] : scripts.files) {
          OutputFolder(job.run).write(fs::path("farm") / name, text);
          if (name.ends_with(".sh")) ::chmod((folder / name).c_str(), 0755);
        }
        const std::string start = (folder / scripts.start).string();
        std::printf("%s\n", visible(start).c_str());
        std::fflush(stdout);
        if (!options->submit) return 0;
        const CapturedChild child = capture_child({"bash", start});
        std::printf("%s", child.output.c_str());
        if (child.exit_code != 0)
          throw WriteError(start + ": ended with " + std::to_string(child.exit_code), EIO);
        return 0;
      });
  options->command = command;
  command
      ->add_option("engine", options->engine,
                   "slurm, parallel (GNU) or openjd (Open Job Description)")
      ->required()
      ->check(CLI::IsMember({"slurm", "parallel", "openjd"}));
  options->add_to(command);
  command->add_option("--shards", options->shards, "number of shards [8]")
      ->check(CLI::Range(1, 100000))
      ->configurable();
  command->add_flag("--submit", options->submit, "submit the job, too (slurm and parallel)");
}

}  // namespace backbend::cli
