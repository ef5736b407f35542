#include <cstdio>
#include <map>

#include "cli/commands.h"
#include "cli/external_options.h"
#include "cli/search_commands.h"
#include "cli/settings.h"
#include "validate/night/standard_runs.h"
#include "validate/report/libraries.h"
#include "validate/why/recorded_run.h"
#include "validate/why/why.h"
#include "validate/why/why_text.h"

namespace backbend::cli {
namespace {

using namespace backbend::validate;

struct WhyOptions {
  std::vector<std::string> versions;
  std::string rig, character, mapping = "chest", chain, characters;
  skin::AnatomyHints hints;
  WhySettings settings;
  ExternalOptions external;
};

/// The versions as they were named: run folders read, and under which rig each is judged.
struct WhyInputs {
  std::map<std::size_t, RecordedRun> runs;  // by the number of the version
  std::vector<RigPlan> rigs;                // of each version
  WhySettings settings;
  bool of_rigs = false;  // the versions are rigs, on one character

  const RecordedRun* run(std::size_t i) const {
    const auto found = runs.find(i);
    return found == runs.end() ? nullptr : &found->second;
  }
  const Failures* recorded(std::size_t i) const { return run(i) ? &run(i)->failures : nullptr; }
};

WhyInputs inputs_of(const WhyOptions& options) {
  WhyInputs out;
  out.settings = options.settings;
  out.settings.mapping = *find_mapping(options.mapping);
  std::string rig = options.rig.empty() ? "even" : options.rig;
  std::size_t first = 0;
  for (std::size_t i = 0; i < options.versions.size(); ++i) {
    const std::string& name = options.versions[i];
    if (!is_recorded_run(name)) continue;
    RecordedRun run = read_recorded_run(name, {options.character, options.rig});
    if (out.runs.empty()) {
      first = i;
    } else if (const std::string why = unlike(out.runs.at(first), run); !why.empty()) {
      throw skin::CharacterError(name + ": cannot be compared with " + options.versions[first] +
                                 ", which was judged otherwise (" + why +
                                 "); check both characters with this version instead");
    }
    // Runs are compared as they were made, and files beside them alike.
    out.settings.mapping = run.mapping;
    out.settings.envelope = run.envelope;
    out.settings.limits = run.limits;
    rig = rig_text(run.rig.spec);
    out.runs.emplace(i, std::move(run));
  }
  out.of_rigs = !options.character.empty() && out.runs.empty();
  for (std::size_t i = 0; i < options.versions.size(); ++i)
    out.rigs.push_back(out.run(i)
                           ? out.run(i)->rig
                           : options.external.read_rig(out.of_rigs ? options.versions[i] : rig));
  out.settings.chain = driven_chain(options.chain, out.rigs.front(), options.hints);
  return out;
}

/// How the programs that measured these versions differ from this one.
std::string programs_text(const WhyOptions& options, const WhyInputs& inputs, std::size_t before,
                          std::size_t after) {
  const std::map<std::string, std::string> own = program_versions();
  std::string text;
  for (const std::size_t i : {before, after}) {
    if (!inputs.run(i)) continue;
    const std::string difference = program_difference(inputs.run(i)->program, own);
    text += (text.empty() ? "" : "; ") + options.versions[i] + ": " +
            (difference.empty() ? "another build of this version" : difference);
  }
  return text;
}

WhyResult run_why(const WhyOptions& options, Progress& progress) {
  const WhyInputs inputs = inputs_of(options);
  const auto load = [&](std::size_t i) {
    const RecordedRun* run = inputs.run(i);
    Version version =
        run ? version_of(*run, options.characters, options.hints, inputs.settings.chain)
            : load_version(inputs.of_rigs ? options.character : options.versions[i], options.hints,
                           inputs.rigs[i]);
    version.label = options.versions[i];
    return version;
  };
  WhyResult out;
  out.versions = options.versions;
  out.rig = inputs.of_rigs ? inputs.rigs.back().name : inputs.rigs.front().name;
  for (const auto& [i, run] : inputs.runs)
    if (run.other_sweeps > 0)
      out.notes.push_back(options.versions[i] + ": " + std::to_string(run.other_sweeps) +
                          (run.other_sweeps == 1 ? " failure" : " failures") +
                          " in other sweeps than those of check left out");
  std::size_t before = 0, after = options.versions.size() - 1;
  if (after > 1) {
    progress.start("versions", options.versions.size());
    out.first_bad = first_bad(options.versions.size(), [&](std::size_t i) {
      poll_interrupt();
      const Failures* recorded = inputs.recorded(i);
      Failures failures = recorded ? *recorded : failures_of(load(i), inputs.settings);
      progress.step();
      return failures;
    });
    progress.finish();
    if (!out.first_bad) return out;
    before = out.first_bad->good;
    after = out.first_bad->bad;
  }
  Version older = load(before), newer = load(after);  // what is wrong with the older is said first
  out.pair = why(VersionPair(std::move(older), std::move(newer)), inputs.settings, progress,
                 {inputs.recorded(before), inputs.recorded(after),
                  programs_text(options, inputs, before, after)});
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
                   "character files or run folders, the oldest first; with --character, rigs")
      ->required()
      ->expected(1, 100000)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  command->add_option("--rig", options->rig, kRigHelp)->type_name(kRigType)->configurable();
  command
      ->add_option("--character", options->character,
                   "character that the versions, which are rigs, are judged on; of runs, which "
                   "of their characters")
      ->type_name(kFileType);
  command
      ->add_option("--characters", options->characters,
                   "folder with the characters that the run folders measured [the working folder]")
      ->type_name("DIR");
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
