#include <cstdio>

#include "cli/commands.h"
#include "solver/rig/solve_file.h"
#include "validate/judge/explain.h"

namespace backbend::cli {

void add_solve(const Registry& registry) {
  struct Options {
    std::string file, sweep;
    bool explain = false;
    std::optional<double> at;
  };
  auto options = std::make_shared<Options>();
  CLI::App* command = registry.add(
      "solve", "solve the spine alone: one pose, or a sweep of one control",
      [options, &common = registry.common] {
        solver::SolveFile file = solver::read_solve_file(options->file);
        if (options->at) {
          if (file.key.empty()) throw solver::RigError(file.name + ": --at, but it has no [[key]]");
          file.control = file.control_at(*options->at);
        }
        if (options->explain) {
          std::fputs(validate::explain_solve(file).c_str(), stdout);
        } else if (!options->sweep.empty()) {
          std::fputs(solver::sweep_to_json_lines(file, options->sweep).c_str(), stdout);
        } else if (common.json) {
          std::printf("%s\n", solver::solve_to_json(file).c_str());
        } else {
          std::fputs(solver::solve_to_text(file).c_str(), stdout);
        }
        return 0;
      });
  command->add_flag("--explain", options->explain,
                    "print inputs, options, order of evaluation, what drifted and why");
  command
      ->add_option("file", options->file,
                   "TOML with [rig], [chain] and [pose], or [[key]]s in time")
      ->required();
  command->add_option("--at", options->at, "the pose at a time between the file's keys");
  command->add_option(
      "--sweep", options->sweep,
      "control.channel=from:to:step in degrees or lengths, or time=from:to:step over "
      "the keys: one JSON object a line");
}

}  // namespace backbend::cli
