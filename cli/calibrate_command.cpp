#include <cstdio>

#include "cli/judging_commands.h"
#include "validate/calibrate/calibrate.h"
#include "validate/files/data_folder.h"
#include "validate/files/folder_trace.h"
#include "validate/files/output_folder.h"
#include "validate/stage/stage.h"
#include "validate/text/escape.h"
#include "validate/verdicts/exit_code.h"

namespace backbend::cli {
namespace {

using namespace backbend::validate;

struct CalibrateOptions {
  std::vector<std::string> characters;
  std::vector<int> tubes{8, 24};
  CalibrationPlan plan;
  std::string output = ".";
  bool dry_run = false;
};

std::vector<std::unique_ptr<CalibrationBody>> bodies_of(const CalibrateOptions& options) {
  std::vector<std::string> files = options.characters;
  if (files.empty())
    files.push_back((data_folder() / "scenes" / "characters" / "human.toml").string());
  std::vector<std::unique_ptr<CalibrationBody>> bodies;
  for (const int bones : options.tubes)
    if (bones > 0) bodies.push_back(tube_body(bones));
  for (const std::string& file : files) {
    skin::Character character = load_character(file);
    skin::Anatomy anatomy = skin::find_anatomy(character, {});
    bodies.push_back(std::make_unique<CalibrationBody>(std::move(character), std::move(anatomy)));
  }
  return bodies;
}

int print_plan(const CalibrateOptions& options, const std::vector<const CalibrationBody*>& bodies,
               const Common& common) {
  const CalibrationPlan& plan = options.plan;
  const double minutes = estimate_minutes(plan, bodies, poll_interrupt);
  if (common.json) {
    std::printf(
        "{\"bodies\": %zu, \"chains\": %zu, \"faults\": %zu, \"minutes\": %s, \"poses\": %zu}\n",
        bodies.size(), plan.chain_bones.size(), plan.fault_poses, number_text(minutes, 2).c_str(),
        plan.clean_poses);
    return kExitOk;
  }
  std::printf("chains   %zu, bodies %zu\n", plan.chain_bones.size(), bodies.size());
  std::printf(
      "poses    %zu clean ones of each, as many that set the thresholds, and %zu of every size of "
      "fault\n",
      plan.clean_poses, plan.fault_poses);
  std::printf("time     about %s minutes on this machine\n", minutes_text(minutes).c_str());
  return kExitOk;
}

int calibrate_and_print(const CalibrateOptions& options, const Common& common) {
  const FolderTrace trace(options.output);
  const OutputFolder folder(options.output);
  if (!options.dry_run) folder.prepare();  // a job of minutes fails early
  const auto bodies = bodies_of(options);
  std::vector<const CalibrationBody*> tried;
  for (const auto& body : bodies) tried.push_back(body.get());
  if (options.dry_run) return print_plan(options, tried, common);
  Progress progress(common.progress_style());
  CalibrationWatch watch;
  watch.on_stage = [&](const std::string& stage, std::size_t steps) {
    progress.start(visible(stage), steps);
  };
  watch.on_step = [&] {
    poll_interrupt();
    progress.step();
  };
  CalibrationReport report = calibrate(options.plan, tried, watch);
  report.date = today();
  progress.finish();
  const std::string json = calibration_json(report);
  folder.write("calibration.json", json);
  folder.write("calibration.md", calibration_table(report));
  if (common.json) {
    std::fputs(json.c_str(), stdout);
  } else {
    for (const std::string& line : detector_lines(report))
      std::printf("%s\n", visible(line).c_str());
    std::printf("\n%s; wrote %s and %s\n",
                report.ok() ? "every detector reached its target with no false alarm"
                            : "some detectors missed their target or raised a false alarm",
                (folder.path() / "calibration.json").c_str(),
                (folder.path() / "calibration.md").c_str());
  }
  return report.ok() ? kExitOk : kExitFindings;
}

}  // namespace

void add_calibrate(const Registry& registry) {
  auto options = std::make_shared<CalibrateOptions>();
  CLI::App* command = registry.add(
      "calibrate", "measure the smallest fault that each detector finds with no false alarm",
      [options, &common = registry.common] { return calibrate_and_print(*options, common); });
  command->add_option("characters", options->characters,
                      "character files for the mesh detectors [the bundled human]");
  command
      ->add_option("--poses", options->plan.clean_poses,
                   "clean poses per body, and as many again to set the thresholds [2000]")
      ->check(CLI::Range(1, 1000000));
  command
      ->add_option("--faults", options->plan.fault_poses, "faulted poses per size and body [200]")
      ->check(CLI::Range(1, 1000000));
  command
      ->add_option("--bones", options->plan.chain_bones,
                   "bone counts of the test chains, separated by commas [6,10,24,33]")
      ->delimiter(',')
      ->check(CLI::Range(3, 64));
  command
      ->add_option("--tubes", options->tubes,
                   "bone counts of the round test bodies, separated by commas; 0: none [8,24]")
      ->delimiter(',')
      ->check(CLI::Range(4, 64) | CLI::IsMember({0}));
  command->add_option("--seed", options->plan.seed, "seed of all poses and faults [20261121]");
  command->add_flag("--dry-run", options->dry_run,
                    "print the plan and the estimated time, then exit");
  command->add_option("-o,--output", options->output,
                      "folder for calibration.json and calibration.md [.]");
}

}  // namespace backbend::cli
