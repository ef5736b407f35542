#include <algorithm>
#include <cstdio>

#include "cli/commands.h"
#include "cli/external_options.h"
#include "cli/search_commands.h"
#include "cli/settings.h"
#include "solver/rig/nearest_name.h"
#include "validate/files/folder_trace.h"
#include "validate/hunt/hunt.h"
#include "validate/hunt/hunt_text.h"
#include "validate/night/standard_runs.h"
#include "validate/text/escape.h"

namespace backbend::cli {
namespace {

namespace fs = std::filesystem;
using namespace backbend::validate;

struct HuntOptions {
  HuntRequest request;
  std::string rig, mapping = "chest", chain, output, suite, resolution;
  ExternalOptions external;
};

HuntRequest finished(const HuntOptions& options) {
  HuntRequest request = options.request;
  request.rig = options.external.read_rig(options.rig);
  request.chain = driven_chain(options.chain, request.rig, request.hints);
  request.mapping = *find_mapping(options.mapping);
  if (const auto codes = huntable_checks();
      !request.check.empty() && std::ranges::find(codes, request.check) == codes.end())
    throw CLI::ValidationError("--check: '" + request.check + "' is not measured pose by pose" +
                               solver::did_you_mean(request.check, codes));
  if (!options.suite.empty()) request.suite = read_suite(options.suite);
  if (!options.resolution.empty())
    std::tie(request.width, request.height) = parse_resolution(options.resolution);
  request.folder = options.output;
  return request;
}

/// Adds the finds to the suite's file; what is said of it.
std::string add_to_suite(const std::string& file, const Hunt& hunt) {
  const std::vector<PoseRow> rows = pose_rows(hunt, read_suite(file));
  if (rows.empty()) return "no pose to add to " + file;
  const fs::path path = fs::absolute(file);
  OutputFolder(path.parent_path()).write(path.filename(), with_poses(read_text(path), rows));
  return "added " + std::to_string(rows.size()) + (rows.size() == 1 ? " pose" : " poses") + " to " +
         file;
}

/// Runs the hunt; one that is stopped says how it goes on.
HuntResult hunted(const HuntRequest& request, Progress& progress) {
  try {
    return run_hunt(request, progress);
  } catch (const Interrupted&) {
    if (!request.folder.empty())
      std::fprintf(stderr, "backbend: the poses measured so far are in %s; --resume goes on\n",
                   visible(request.folder.string()).c_str());
    throw;
  }
}

}  // namespace

void add_hunt(const Registry& registry) {
  auto options = std::make_shared<HuntOptions>();
  CLI::App* command = registry.add(
      "hunt", "search a box of poses for the worst pose of a rig, check by check",
      [options, &common = registry.common] {
        HuntRequest request = finished(*options);
        if (request.resume && request.folder.empty())
          throw CLI::ValidationError("--resume continues the hunt in the folder that -o names");
        if (!common.json)
          request.on_character = [&](const CharacterFacts& facts, const ControlBox&) {
            print_character("hunting the worst poses of rig " + request.rig.name, facts);
          };
        Progress progress(common.progress_style());
        const FolderTrace trace(request.folder);
        if (!request.folder.empty()) OutputFolder(request.folder).prepare();
        const HuntResult result = hunted(request, progress);
        const std::string json = hunt_json(result) + "\n";
        if (!request.folder.empty()) OutputFolder(request.folder).write("hunt.json", json);
        std::fputs((common.json ? json : hunt_text(result)).c_str(), stdout);
        if (!options->suite.empty())
          std::fprintf(common.json ? stderr : stdout, "%s\n",
                       visible(add_to_suite(options->suite, result.hunt)).c_str());
        return result.exit_code();
      });
  command->add_option("rig", options->rig, kRigHelp)->required()->type_name(kRigType);
  command->add_option("--character", options->request.character, "character file")
      ->required()
      ->type_name(kFileType);
  command->add_option(
      "--box", options->request.box,
      "poses to search: envelope, stress, sweep, a TOML file with [box], or channels "
      "like extension=0:180,side=0 in degrees [envelope]");
  command->add_option("--check", options->request.check,
                      "hunt this check alone (BB001 ...) [every check of single poses]");
  command
      ->add_option("--evaluations", options->request.evaluations,
                   "poses to measure, 100 to 10000000 [5000]")
      ->check(CLI::Range(100, 10'000'000));
  command->add_option("--seed", options->request.seed, "seed of the search [1]");
  add_mapping_option(command, options->mapping)->configurable();
  command
      ->add_option("--envelope", options->request.envelope,
                   "poses that count as required [the sidecar's, or by the kind of body]")
      ->check(CLI::IsMember(envelope_names()));
  command
      ->add_option("--add-to", options->suite,
                   "add each find to this suite as a named pose; its limits count")
      ->type_name(kFileType);
  command->add_option("-o,--output", options->output,
                      "folder for hunt.json and a picture of each find [none]");
  command->add_flag("--resume", options->request.resume,
                    "go on with the same hunt that was stopped in the folder of -o");
  command->add_option("--res", options->resolution, "picture size, WIDTHxHEIGHT pixels [640x480]")
      ->check(picture_size())
      ->configurable();
  options->external.add_to(command);
  add_anatomy_options(command, options->request.hints);
  add_chain_option(command, options->chain);
}

}  // namespace backbend::cli
