#include <cstdio>

#include "cli/commands.h"
#include "cli/external_options.h"
#include "cli/search_commands.h"
#include "cli/settings.h"
#include "validate/night/standard_runs.h"
#include "validate/why/why.h"
#include "validate/why/why_text.h"

namespace backbend::cli {
namespace {

using namespace backbend::validate;

struct WhyOptions {
  std::vector<std::string> versions;
  std::string rig = "even", character, mapping = "chest", chain;
  skin::AnatomyHints hints;
  WhySettings settings;
  ExternalOptions external;
};

WhyResult run_why(const WhyOptions& options, Progress& progress) {
  const bool of_rigs = !options.character.empty();
  std::vector<RigPlan> rigs;
  for (const std::string& each : options.versions)
    rigs.push_back(options.external.read_rig(of_rigs ? each : options.rig));
  WhySettings settings = options.settings;
  settings.mapping = *find_mapping(options.mapping);
  settings.chain = driven_chain(options.chain, rigs.front(), options.hints);
  const auto load = [&](std::size_t i) {
    Version version =
        load_version(of_rigs ? options.character : options.versions[i], options.hints, rigs[i]);
    version.label = options.versions[i];
    return version;
  };
  WhyResult out;
  out.versions = options.versions;
  out.rig = of_rigs ? rigs.back().name : rigs.front().name;
  std::size_t before = 0, after = options.versions.size() - 1;
  if (after > 1) {
    progress.start("versions", options.versions.size());
    out.first_bad = first_bad(options.versions.size(), [&](std::size_t i) {
      poll_interrupt();
      Failures failures = failures_of(load(i), settings);
      progress.step();
      return failures;
    });
    progress.finish();
    if (!out.first_bad) return out;
    before = out.first_bad->good;
    after = out.first_bad->bad;
  }
  out.pair = why(VersionPair(load(before), load(after)), settings, progress);
  return out;
}

}  // namespace

void add_why(const Registry& registry) {
  auto options = std::make_shared<WhyOptions>();
  CLI::App* command = registry.add(
      "why", "which ingredient of a new version made each new or worse finding",
      [options, &common = registry.common] {
        if (options->versions.size() < 2)
          throw CLI::ValidationError("why needs two versions or more, the oldest first");
        Progress progress(common.progress_style());
        const WhyResult result = run_why(*options, progress);
        progress.finish();
        std::fputs((common.json ? why_json(result) + "\n" : why_text(result)).c_str(), stdout);
        return result.exit_code();
      });
  command
      ->add_option("versions", options->versions,
                   "character files, the oldest first; with --character, rigs")
      ->required()
      ->expected(1, 100000)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  command->add_option("--rig", options->rig, kRigHelp)->type_name(kRigType)->configurable();
  command
      ->add_option("--character", options->character,
                   "character that the versions, which are rigs, are judged on")
      ->type_name(kFileType);
  add_mapping_option(command, options->mapping)->configurable();
  command
      ->add_option("--envelope", options->settings.envelope,
                   "required range [the sidecar's, or by the kind of body]")
      ->check(CLI::IsMember(envelope_names()));
  options->external.add_to(command);
  add_anatomy_options(command, options->hints);
  add_chain_option(command, options->chain);
}

}  // namespace backbend::cli
