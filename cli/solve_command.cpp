#include <cstdio>

#include "cli/commands.h"
#include "cli/external_options.h"
#include "cli/settings.h"
#include "solver/rig/solve_file.h"
#include "validate/judge/confirmed.h"
#include "validate/judge/explain.h"
#include "validate/measure/measure.h"
#include "validate/night/standard_runs.h"
#include "validate/stage/stage.h"
#include "validate/verdicts/exit_code.h"

namespace backbend::cli {
namespace {

using namespace backbend::validate;

struct SolveOptions {
  std::string file, sweep;
  bool explain = false;
  std::optional<double> at;
  std::string character, pose, chain, mapping = "chest";
  skin::AnatomyHints hints;
  ExternalOptions external;
};

void print(const solver::SolveFile& file, const SolveOptions& options, const Common& common) {
  if (options.explain)
    std::fputs(explain_solve(file).c_str(), stdout);
  else if (!options.sweep.empty())
    std::fputs(solver::sweep_to_json_lines(file, options.sweep).c_str(), stdout);
  else if (common.json)
    std::printf("%s\n", solver::solve_to_json(file).c_str());
  else
    std::fputs(solver::solve_to_text(file).c_str(), stdout);
}

int solve_file(const SolveOptions& options, const Common& common) {
  if (!options.pose.empty()) throw CLI::ValidationError("--pose needs --character");
  options.external.apply_to({});
  solver::SolveFile file = solver::read_solve_file(options.file);
  if (options.at) {
    if (file.key.empty()) throw solver::RigError(file.name + ": --at, but it has no [[key]]");
    file.control = file.control_at(*options.at);
  }
  print(file, options, common);
  return kExitOk;
}

/// A rig on a character's spine: one pose of the body, or a sweep of one of its channels or of the
/// rig's own.
int solve_on_character(const SolveOptions& options, const Common& common) {
  if (options.at) throw CLI::ValidationError("--at is of a file with [[key]]s, not of a character");
  const RigPlan rig = options.external.read_rig(options.file);
  PoseDegrees pose = options.pose.empty() ? PoseDegrees{} : parse_pose(options.pose);
  ConfirmedCharacter confirmed = load_confirmed(options.character, options.hints);
  const Stage stage(
      std::move(confirmed.character), confirmed.hints,
      driven_chain(options.chain, rig, options.hints),
      confirmed.sidecar ? confirmed.sidecar->controls : std::vector<skin::SidecarControl>());
  solver::SolveFile file;
  file.name = rig.name;
  file.system = stage.build(rig.spec);
  const auto controls = [&] {
    return controls_at(*file.system, pose, *find_mapping(options.mapping));
  };
  const std::size_t equals = std::min(options.sweep.find('='), options.sweep.size());
  const std::string channel = options.sweep.substr(0, equals);
  if (double* degrees = pose.find(channel); degrees != nullptr && !options.explain) {
    const std::vector<double> range = solver::parse_range(
        std::string_view(options.sweep).substr(std::min(equals + 1, options.sweep.size())),
        "sweep '" + options.sweep + "': ");
    std::fputs(solver::sweep_to_json_lines(*file.system, channel, range,
                                           [&](std::size_t i) {
                                             *degrees = range[i];
                                             return controls();
                                           })
                   .c_str(),
               stdout);
    return kExitOk;
  }
  file.control = controls();
  print(file, options, common);
  return kExitOk;
}

}  // namespace

void add_solve(const Registry& registry) {
  auto options = std::make_shared<SolveOptions>();
  CLI::App* command =
      registry.add("solve", "solve the spine alone: one pose, or a sweep of one control",
                   [options, &common = registry.common] {
                     return options->character.empty() ? solve_file(*options, common)
                                                       : solve_on_character(*options, common);
                   });
  command->add_flag("--explain", options->explain,
                    "print inputs, options, order of evaluation, what drifted and why");
  command
      ->add_option("file", options->file,
                   "TOML with [rig], [chain] and [pose], or [[key]]s in time; with --character the "
                   "rig: a system, a rig file, or your own, live")
      ->required();
  command->add_option("--at", options->at, "the pose at a time between the file's keys");
  command->add_option(
      "--sweep", options->sweep,
      "control.channel=from:to:step in degrees or lengths, time=from:to:step over the keys, or "
      "with --character extension=from:to:step: one JSON object a line");
  command
      ->add_option("--character", options->character,
                   "character whose spine is driven, in place of [chain]")
      ->type_name(kFileType);
  command->add_option("--pose", options->pose,
                      "with --character: extension=90,side=10 in degrees [rest]");
  add_mapping_option(command, options->mapping);
  options->external.add_to(command);
  add_anatomy_options(command, options->hints);
  add_chain_option(command, options->chain);
}

}  // namespace backbend::cli
