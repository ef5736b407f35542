#include <cstdio>

#include "cli/commands.h"
#include "cli/search_commands.h"
#include "cli/settings.h"
#include "validate/files/folder_trace.h"
#include "validate/files/output_folder.h"
#include "validate/files/replaceable.h"
#include "validate/night/standard_runs.h"
#include "validate/text/escape.h"
#include "validate/tune/rig_file.h"
#include "validate/tune/tune.h"
#include "validate/tune/tune_text.h"

namespace backbend::cli {
namespace {

namespace fs = std::filesystem;
using namespace backbend::validate;

struct TuneOptions {
  TuneRequest request;
  std::string rig, mapping = "chest", chain, output;
  bool no_picture = false;
};

TuneRequest finished(const TuneOptions& options) {
  TuneRequest request = options.request;
  if (options.output.empty() && !request.plan_only)
    throw CLI::ValidationError("tune: one of -o RIG.toml or --dry-run is required");
  const fs::path output(options.output);
  if (!options.output.empty() && output.extension() != ".toml")
    throw CLI::ValidationError("-o: '" + options.output + "': expected a name that ends in .toml");
  std::error_code none;
  for (const fs::path& input : {fs::path(options.rig), request.character})
    if (!options.output.empty() && fs::equivalent(output, input, none))
      throw CLI::ValidationError("'" + options.output + "' is an input; write to another file");
  request.rig = read_rig(options.rig);
  request.chain = driven_chain(options.chain, request.rig, request.hints);
  request.mapping = *find_mapping(options.mapping);
  request.picture = !options.no_picture && !request.plan_only;
  return request;
}

/// Writes the chosen rig, and the sheet of all beside it; what was written.
std::vector<fs::path> write(const TuneResult& result, const fs::path& file) {
  const OutputFolder folder(file.parent_path());
  std::vector<fs::path> written;
  if (!result.sheet.empty()) {
    written.push_back(file.parent_path() / (file.stem().string() + "_choices.png"));
    folder.write(written.back().filename(), result.sheet);
  }
  if (result.chosen) {
    const solver::SystemSpec& spec = result.choices[*result.chosen].spec;
    folder.write(file.filename(), rig_toml(spec, rig_file_comment(result)));
    written.push_back(file);
  }
  return written;
}

int run_tune(const TuneOptions& options, const Common& common) {
  TuneRequest request = finished(options);
  const fs::path file(options.output);
  const FolderTrace trace(file.parent_path());
  if (!request.plan_only) {
    require_replaceable(file);
    OutputFolder(file.parent_path()).prepare();
  }
  if (!common.json)
    request.on_character = [&](const CharacterFacts& facts) {
      print_character("tuning rig " + request.rig.name, facts);
    };
  Progress progress(common.progress_style());
  const TuneResult result = [&] {
    try {
      return tune(request, progress);
    } catch (const VaryError& error) {
      throw CLI::ValidationError(error.what());
    }
  }();
  const bool planned = request.plan_only;
  std::fputs((common.json ? tune_json(result, planned) + "\n" : tune_text(result, planned)).c_str(),
             stdout);
  std::fflush(stdout);
  if (planned) return 0;
  const std::vector<fs::path> written = write(result, file);
  if (common.quiet) return 0;
  if (!result.chosen) std::fprintf(stderr, "no rig file was written\n");
  for (const fs::path& each : written)
    std::fprintf(stderr, "wrote %s\n", visible(each.string()).c_str());
  return 0;
}

}  // namespace

void add_tune(const Registry& registry) {
  auto options = std::make_shared<TuneOptions>();
  TuneRequest& request = options->request;
  CLI::App* command = registry.add(
      "tune", "search a rig's options for more headroom at less change of shape, write a rig file",
      [options, &common = registry.common] { return run_tune(*options, common); });
  command
      ->add_option("rig", options->rig,
                   "rig: a system (backbend list rigs), with options or not, or a rig file")
      ->required()
      ->type_name(kRigType);
  command->add_option("--for", request.character, "character file that the rig is tuned for")
      ->required()
      ->type_name(kFileType);
  command->add_option("-o,--output", options->output,
                      "the rig file to write, .toml; a sheet of all choices, _choices.png, goes "
                      "beside it");
  command
      ->add_option("--vary", request.vary,
                   "options to vary, with commas between, each NAME or NAME=FROM:TO [all that "
                   "have a range and change anything]")
      ->delimiter(',');
  command
      ->add_option("--evaluations", request.evaluations,
                   "rigs to measure in the search, 20 to 100000 [200]")
      ->check(CLI::Range(20, 100'000));
  command
      ->add_option("--change", request.change,
                   "how far the curve of the written rig may be from the given one's, per cent of "
                   "the spine's length, root mean square over the envelope's poses, 0 to 100 [5]")
      ->check(CLI::Range(0.0, 100.0));
  command->add_flag("--no-picture", options->no_picture, "write no sheet of pictures");
  command->add_flag("--dry-run", request.plan_only,
                    "measure the given rig, print what would be varied and about how long, then "
                    "exit");
  add_mapping_option(command, options->mapping)->configurable();
  command
      ->add_option("--envelope", request.envelope,
                   "poses that count as required [the sidecar's, or by the kind of body]")
      ->check(CLI::IsMember(envelope_names()));
  add_anatomy_options(command, request.hints);
  add_chain_option(command, options->chain);
}

}  // namespace backbend::cli
