#include <algorithm>
#include <cstdio>

#include "cli/external_options.h"
#include "cli/nightly.h"
#include "cli/settings.h"
#include "validate/compare/comparison.h"
#include "validate/files/output_folder.h"
#include "validate/model/report_json.h"
#include "validate/night/standard_runs.h"
#include "validate/sweeps/external_spec.h"
#include "validate/verdicts/exit_code.h"

namespace backbend::cli {
namespace {

namespace fs = std::filesystem;
using namespace backbend::validate;

enum class SideKind { rig, character, clip, run };

struct CompareOptions : RunOptions {
  std::string first, second, character, rig = "even", mapping = "chest", sweeps = "stress";
  ExternalOptions external;
  bool baked = false, dry_run = false;
};

std::string word_of(SideKind kind) {
  switch (kind) {
    case SideKind::rig:
      return "a rig";
    case SideKind::character:
      return "a character";
    case SideKind::clip:
      return "a clip";
    default:
      return "a run";
  }
}

/// report.json of a run folder, or the file itself.
fs::path report_of(const fs::path& run) {
  return fs::is_directory(run) ? run / "report.json" : run;
}

/// What a name on the command line means: what is not a file is a rig.
SideKind kind_of(const std::string& text, bool baked) {
  if (parse_external(text)) return SideKind::rig;
  const fs::path path(text);
  std::error_code none;
  if (fs::is_directory(path, none) || path.filename() == "report.json") return SideKind::run;
  std::string ending = path.extension().string();
  for (char& c : ending) c = static_cast<char>(c >= 'A' && c <= 'Z' ? c + 32 : c);
  if (ending == ".toml" && fs::exists(path, none)) {
    return is_rig_file(path) ? SideKind::rig : SideKind::character;
  }
  const bool body = ending == ".glb" || ending == ".gltf" || ending == ".fbx" || ending == ".dae";
  if (body) return baked ? SideKind::clip : SideKind::character;
  if (ending == ".clip" || ending == ".bvh" || ending == ".mdd" || ending == ".pc2")
    return SideKind::clip;
  return fs::exists(path, none) ? SideKind::clip : SideKind::rig;
}

int run_or_plan(RunRequest request, const CompareOptions& options, const Common& common) {
  options.apply_to(request);
  if (options.dry_run) return print_estimate(request, common);
  return run_and_print(std::move(request), common, options);
}

int compare_rigs(const CompareOptions& options, const Common& common) {
  RigPlan proposed = read_rig(options.first), reference = read_rig(options.second);
  options.external.apply_to({&proposed, &reference});
  return run_or_plan(
      compare_rigs_request({std::move(proposed), std::move(reference), options.character,
                            *find_mapping(options.mapping), options.sweeps}),
      options, common);
}

int compare_characters(const CompareOptions& options, const Common& common) {
  return run_or_plan(compare_characters_request({options.first, options.second,
                                                 options.external.read_rig(options.rig),
                                                 *find_mapping(options.mapping), options.sweeps}),
                     options, common);
}

int compare_clips(const CompareOptions& options, const Common& common) {
  const auto judged = [&](const std::string& clip) {
    BakedOptions baked;
    baked.clip = clip;
    return baked_report(baked, options.character, options.hints, common);
  };
  const Report before = judged(options.first);
  Report now = judged(options.second);
  const auto [first, second] = side_labels(options.first, options.second);
  now.title = second + " against " + first;
  now.is_comparison = true;
  now.comparisons = {compare_results(now.rigs.front(), before.rigs.front(), second, first)};
  return publish(now, new_run_folder(options.output), options.output.empty(), common,
                 options.single_file);
}

/// Every rig that both runs have, under the same mapping; of one character each, whatever its name.
std::vector<Comparison> compare_reports(const Report& before, const Report& now,
                                        const CompareOptions& options) {
  const bool by_name = before.characters.size() != 1 || now.characters.size() != 1;
  const auto [first, second] = side_labels(options.first, options.second);
  std::vector<Comparison> comparisons;
  for (const RigResult& rig : now.rigs) {
    for (const RigResult& earlier : before.rigs) {
      if (rig.rig != earlier.rig || rig.mapping != earlier.mapping ||
          (by_name && rig.character != earlier.character))
        continue;
      comparisons.push_back(compare_results(rig, earlier, second, first));
      comparisons.back().character = rig.character + ", rig " + rig.rig;
    }
  }
  return comparisons;
}

int compare_runs(const CompareOptions& options, const Common& common) {
  const auto read = [](const std::string& run) {
    const fs::path file = report_of(run);
    return parse_report(read_text(file), file.string());
  };
  Report report;
  const Report before = read(options.first), now = read(options.second);
  report.comparisons = compare_reports(before, now, options);
  if (report.comparisons.empty())
    throw ReportError(options.second + ": has no rig in common with " + options.first);
  if (common.json)
    std::printf("%s\n", comparisons_json(report.comparisons).c_str());
  else
    std::printf("%s", comparisons_text(report, style_of_stdout()).c_str());
  const bool worse = std::any_of(report.comparisons.begin(), report.comparisons.end(),
                                 [](const Comparison& each) { return each.a_over > each.b_over; });
  return worse ? kExitFindings : kExitOk;
}

int run_compare(const CompareOptions& options, const Common& common) {
  const SideKind kind = kind_of(options.first, options.baked);
  const SideKind other = kind_of(options.second, options.baked);
  if (kind != other)
    throw CLI::ValidationError("'" + options.first + "' is " + word_of(kind) + " and '" +
                               options.second + "' is " + word_of(other) +
                               ": two of one kind can be compared");
  if (options.dry_run && (kind == SideKind::clip || kind == SideKind::run))
    throw CLI::ValidationError("--dry-run: clips and run folders are only read; nothing to plan");
  switch (kind) {
    case SideKind::rig:
      return compare_rigs(options, common);
    case SideKind::character:
      return compare_characters(options, common);
    case SideKind::clip:
      return compare_clips(options, common);
    default:
      return compare_runs(options, common);
  }
}

}  // namespace

void add_compare(const Registry& registry) {
  auto options = std::make_shared<CompareOptions>();
  CLI::App* command =
      registry.add("compare", "compare two rigs, characters, clips or run folders, pose by pose",
                   [options, &common = registry.common] { return run_compare(*options, common); });
  command
      ->add_option("A", options->first,
                   "the proposed rig (a system or a rig file); or the earlier character, clip or "
                   "run folder")
      ->required();
  command->add_option("B", options->second, "the rig to compare with; or the later one")
      ->required();
  command->add_option("--character", options->character,
                      "character file, for rigs and clips [rigs: the bundled human]");
  command->add_option("--rig", options->rig, "rig that two characters are compared under [even]")
      ->type_name(kRigType)
      ->configurable();
  options->external.add_to(command);
  command->add_flag(
      "--baked", options->baked,
      "compare the animations in two .glb, .gltf, .fbx or .dae files, not the bodies");
  command->add_option("--mapping", options->mapping, "chest or spread [chest]")
      ->check(CLI::IsMember({"chest", "spread"}))
      ->configurable();
  command->add_option("--sweeps", options->sweeps, "standard or stress [stress]")
      ->check(CLI::IsMember({"standard", "stress"}))
      ->configurable();
  command->add_flag("--dry-run", options->dry_run,
                    "print the plan and the estimated time, then exit");
  options->add_to(command);
}

}  // namespace backbend::cli
