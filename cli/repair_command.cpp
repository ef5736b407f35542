#include <cstdio>

#include "cli/commands.h"
#include "cli/judging_commands.h"
#include "skin/anatomy/sidecar.h"
#include "skin/weights/weight_export.h"
#include "validate/files/output_folder.h"
#include "validate/files/replaceable.h"
#include "validate/repair/repair_text.h"
#include "validate/text/escape.h"
#include "validate/verdicts/exit_code.h"

namespace backbend::cli {

namespace fs = std::filesystem;
using namespace backbend::validate;

namespace {

struct RepairOptions {
  std::string character, output, weights;
  bool dry_run = false, no_picture = false;
  skin::AnatomyHints hints;
};

/// Usage errors that need no file to be read.
void check_options(const RepairOptions& options) {
  if (options.output.empty() && options.weights.empty() && !options.dry_run)
    throw CLI::ValidationError(
        "repair: one of -o OUT.glb, --weights FILE or --dry-run is required");
  if (!options.output.empty() && fs::path(options.output).extension() != ".glb")
    throw CLI::ValidationError("-o: '" + options.output + "': expected a name that ends in .glb");
  const std::string kind = fs::path(options.weights).extension().string();
  if (!options.weights.empty() && kind != ".xml" && kind != ".json" && kind != ".py")
    throw CLI::ValidationError("--weights: '" + options.weights +
                               "': expected a name that ends in .xml (Maya), .json or .py "
                               "(Blender)");
  std::error_code none;
  for (const std::string& file : {options.output, options.weights})
    if (!file.empty() && fs::equivalent(file, options.character, none))
      throw CLI::ValidationError("'" + file + "' is the character itself; write to another file");
}

std::string weights_text(const fs::path& file, const WeightRepair& repair) {
  const skin::WeightExport from{repair.character, repair.influences, repair.touched};
  if (file.extension() == ".xml") return skin::maya_weights_xml(from);
  if (file.extension() == ".json") return skin::weights_json(from);
  return skin::blender_weights_script(from);
}

int run_repair(const RepairOptions& options, const Common& common) {
  check_options(options);
  const fs::path file(options.output), weights(options.weights);
  if (!options.dry_run)
    for (const fs::path& each : {file, weights})
      if (!each.empty()) {
        require_replaceable(each);
        OutputFolder(each.parent_path()).prepare();
      }
  Progress progress(common.progress_style());
  const bool with_sheet = !options.dry_run && !options.no_picture && !file.empty();
  const WeightRepair repair =
      repair_weights(options.character, options.hints, progress, with_sheet);
  std::fputs(common.json ? repair_json(repair).c_str() : repair_text(repair).c_str(), stdout);
  std::fflush(stdout);
  const auto say = [&](const std::string& line) {
    if (!common.quiet) std::fprintf(stderr, "%s\n", visible(line).c_str());
  };
  const bool changed = !repair.glb.empty();
  if (options.dry_run || !changed) {
    if (!options.dry_run || changed) say("nothing was written");
  } else {
    if (!weights.empty()) {
      OutputFolder(weights.parent_path()).write(weights.filename(), weights_text(weights, repair));
      say("wrote " + weights.string());
    }
    if (!file.empty()) {
      OutputFolder(file.parent_path()).write(file.filename(), repair.glb);
      say("wrote " + file.string());
      if (!repair.sheet.empty()) {
        const fs::path sheet = file.parent_path() / (file.stem().string() + "_repair.png");
        OutputFolder(sheet.parent_path()).write(sheet.filename(), repair.sheet);
        say("wrote " + sheet.string());
      }
      const fs::path sidecar = skin::sidecar_path(options.character);
      std::error_code none;
      if (fs::exists(sidecar, none) && !fs::exists(skin::sidecar_path(file), none))
        say("its sidecar stays where it is: copy " + sidecar.string() + " to " +
            skin::sidecar_path(file).string());
    }
  }
  return repair.after.empty() ? kExitOk : kExitFindings;
}

}  // namespace

void add_repair(const Registry& registry) {
  auto options = std::make_shared<RepairOptions>();
  CLI::App* command = registry.add(
      "repair",
      "repair weights that check finds at fault, measure again, and write the character, .glb",
      [options, &common = registry.common] { return run_repair(*options, common); });
  command->add_option("character", options->character, "character file: .glb or .gltf")->required();
  command->add_option("-o,--output", options->output,
                      "the .glb to write: the character with other weights and nothing else "
                      "changed");
  command->add_option("--weights", options->weights,
                      "write the weights alone: .xml for Maya's deformerWeights, .json in mGear's "
                      "layout, .py for Blender");
  command->add_flag("--no-picture", options->no_picture,
                    "write no pictures of before and after beside the .glb (_repair.png)");
  command->add_flag("--dry-run", options->dry_run, "measure and print; write nothing");
  add_anatomy_options(command, options->hints);
}

}  // namespace backbend::cli
