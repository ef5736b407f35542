#include <sys/ioctl.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <list>

#include "cli/commands.h"
#include "cli/external_options.h"
#include "cli/nightly.h"
#include "cli/no_folder.h"
#include "cli/settings.h"
#include "cli/watch.h"
#include "validate/calibrate/calibrate.h"
#include "validate/carry/input_files.h"
#include "validate/farm/job.h"
#include "validate/files/data_folder.h"
#include "validate/files/folder_trace.h"
#include "validate/files/hash.h"
#include "validate/files/output_folder.h"
#include "validate/history/history_index.h"
#include "validate/history/trend.h"
#include "validate/model/report_json.h"
#include "validate/night/run.h"
#include "validate/night/standard_runs.h"
#include "validate/report/terminal.h"
#include "validate/sweeps/external_spec.h"
#include "validate/sweeps/suite.h"
#include "validate/text/escape.h"
#include "validate/verdicts/exit_code.h"

namespace backbend::cli {
namespace fs = std::filesystem;
using namespace backbend::validate;

void RunOptions::add_to(CLI::App* command) {
  const CLI::Validator named(
      [](const std::string& file) { return file.empty() ? "expected a file's name" : ""; }, "");
  command->add_option("-o,--output", output,
                      "run folder [runs/DATE_TIME with a link 'latest']; -: none, only measure and "
                      "print");
  command->add_flag("--quick", quick, "measure only: no pictures")->configurable();
  command->add_option("--res", resolution, "picture size, WIDTHxHEIGHT pixels [640x480]")
      ->check(picture_size())
      ->configurable();
  command
      ->add_option("--spp", samples,
                   "samples a pixel of the pictures at most; clean tiles end at half [16]")
      ->check(CLI::Range(1, 65536))
      ->configurable();
  command->add_flag("--single-file", single_file, "embed every picture in the page")
      ->configurable();
  command
      ->add_option("--baseline", baseline,
                   "approved failures (backbend approve): only new or worse ones fail")
      ->check(named)
      ->type_name(kFileType);
  command
      ->add_option("--history", history,
                   "history to add this night to, for trends [nightly: runs/history.jsonl]")
      ->check(named)
      ->type_name(kFileType);
  command->add_option("--label", label, "version label in the history, like v013");
  add_anatomy_options(command, hints);
}

void RunOptions::apply_to(PicturePlan& pictures) const {
  if (quick || output == kNoFolder) pictures.enabled = false;
  if (samples > 0) pictures.samples = samples;
  if (!resolution.empty()) std::tie(pictures.width, pictures.height) = parse_resolution(resolution);
}

void RunOptions::apply_to(RunRequest& request) const {
  request.hints = hints;
  if (quick || output == kNoFolder) request.image_pass = false;
  apply_to(request.suite.pictures);
  request.today = today();
  request.label = label;
  // Read before the work, so that what is damaged is said now and not in the morning.
  if (!history.empty()) {
    const HistoryIndex index(history);
    // One more than a trend shows: a night that is taken up again leaves its own out.
    request.history = index.last_nights(request.suite.name, kTrendNights + 1, {});
    request.history_results = index.results();
    request.calibrated =
        last_calibration(fs::path(history).parent_path() / "calibration.json", request.today);
  }
  if (!baseline.empty()) {
    if (!fs::exists(baseline))
      throw NoBaseline(baseline + ": no such baseline; create one with backbend approve");
    request.baseline = parse_baseline(read_text(baseline), baseline);
    if (request.baseline->suite != request.suite.name)
      throw BaselineError(baseline + ": this baseline is of suite '" + request.baseline->suite +
                          "', not of '" + request.suite.name + "'");
  }
}

void NightlyOptions::add_to(CLI::App* command) {
  command->add_option("suite", suite, "suite file [the bundled scenes/nightly.toml]")
      ->type_name(kFileType)
      ->configurable();
  command->add_option("--character", character, "character file instead of the suite's")
      ->type_name(kFileType);
  command
      ->add_option("--hunt-percent", hunt_percent,
                   "poses to search for the worst of each rig, per cent of those that its sweeps "
                   "measure; 0: none [the suite's, 50; with --quick 0]")
      ->check(CLI::Range(0.0, kMostHuntPercent))
      ->configurable();
  RunOptions::add_to(command);
  // A night is what a house keeps record of; a check in between is not held to it.
  command->get_option("--baseline")->configurable();
  command->get_option("--history")->configurable();
}

RunRequest NightlyOptions::request() const {
  RunRequest request;
  const fs::path file = suite.empty() ? data_folder() / "scenes" / "nightly.toml" : fs::path(suite);
  request.suite = read_suite(file);
  if (!character.empty()) request.suite.characters = {character};
  if (hunt_percent >= 0.0)
    request.suite.hunt.percent = hunt_percent;
  else if (quick)
    request.suite.hunt.percent = 0.0;
  apply_to(request);
  request.character = character;
  return request;
}

/// runs/2026-11-21_093100: local time, because people look for "this morning's run". The folder is
/// made at once, so that another run of this second takes another name, and removed at the
/// program's end where nothing was written.
fs::path new_run_folder(const std::string& wanted) {
  if (!wanted.empty()) return wanted;
  const std::time_t now = std::time(nullptr);
  std::tm local = {};
  localtime_r(&now, &local);
  char name[80];
  std::snprintf(name, sizeof name, "%04d-%02d-%02d_%02d%02d%02d", local.tm_year + 1900,
                local.tm_mon + 1, local.tm_mday, local.tm_hour, local.tm_min, local.tm_sec);
  static std::list<FolderTrace> made;
  fs::path folder = fs::path("runs") / name;
  for (int again = 2;; ++again) {
    made.emplace_back(folder);
    std::error_code error;
    fs::create_directories(folder.parent_path(), error);
    if (fs::create_directory(folder, error) || error) break;  // whoever writes there says what
    made.back().keep();
    folder = fs::path("runs") / (std::string(name) + "-" + std::to_string(again));
  }
  return folder;
}

namespace {

/// Joint names from the hips up; of a chain that would fill the screen (a snake's) the two ends.
std::string chain_text(const std::vector<std::string>& joints) {
  constexpr std::size_t kMost = 24, kStart = 6, kEnd = 3;
  std::string text;
  for (std::size_t i = 0; i < joints.size(); ++i) {
    if (joints.size() > kMost && i == kStart) {
      text += " > (" + std::to_string(joints.size() - kStart - kEnd) + " more)";
      i = joints.size() - kEnd;
    }
    text += (text.empty() ? "" : " > ") + visible(joints[i]);
  }
  return text.empty() ? "none found" : text;
}

}  // namespace

void print_character(const std::string& title, const CharacterFacts& facts, bool has_baseline) {
  const char* const sure = facts.doubts.empty() ? "   sure" : "   uncertain";
  std::printf("%s\n", visible(title).c_str());
  std::printf(
      "  body   %d part%s, %d vertices, %s high, spine %s long (file units; the reference "
      "length)\n",
      facts.meshes, facts.meshes == 1 ? "" : "s", facts.vertices,
      number_text(facts.height, 3).c_str(), number_text(facts.spine_length, 3).c_str());
  std::printf("  spine  %s%s\n", chain_text(facts.spine).c_str(), sure);
  for (const std::string& doubt : facts.doubts)
    std::printf("  doubt  %s\n", visible(doubt).c_str());
  const std::string left = facts.left_arm.empty() ? "none" : visible(facts.left_arm.front());
  const std::string right = facts.right_arm.empty() ? "none" : visible(facts.right_arm.front());
  std::printf("  arms   %s, %s\n", left.c_str(), right.c_str());
  for (const std::string& note : facts.notes) std::printf("  note   %s\n", visible(note).c_str());
  std::printf("  limits envelope '%s' (%s), %s\n\n", facts.envelope.c_str(),
              visible(facts.envelope_reason).c_str(),
              has_baseline ? "baseline: new or worse fails" : "no baseline: absolute limits");
  std::fflush(stdout);
}

int print_report(const Report& report, const fs::path& page, const Common& common) {
  if (common.json) {
    std::printf("%s\n", report_json(report).c_str());
  } else {
    TerminalStyle style = style_of_stdout();
    style.page = page.string();
    std::printf("%s", terminal_summary(report, style).c_str());
  }
  return report.exit_code;
}

int publish(const Report& report, const fs::path& folder, bool is_latest, const Common& common,
            bool single_file) {
  if (folder == kNoFolder) return print_report(report, {}, common);
  write_report(report, folder, {{}, single_file});
  if (is_latest) point_link(folder.parent_path() / "latest", folder.filename());
  return print_report(report, folder / "index.html", common);
}

namespace {

Shard shard_of(const std::string& text) {
  try {
    return parse_shard(text);
  } catch (const std::invalid_argument& error) {
    throw CLI::ValidationError(std::string("--shard: ") + error.what());
  }
}

/// A night that this very folder's report has added already is none of the earlier ones, so that a
/// night that is taken up or merged again says the same again.
void leave_out_this_night(RunRequest& request) {
  const fs::path report = request.folder / "report.json";
  if (!request.history || !fs::exists(report)) return;
  const std::string hash = content_hash(read_bytes(report));
  std::erase_if(*request.history, [&](const Night& night) { return night.report == hash; });
}

}  // namespace

int run_and_print(RunRequest request, const Common& common, const RunOptions& options) {
  if (!common.json) {
    request.on_character = [&request](const CharacterFacts& facts) {
      const std::string& title = request.title.empty() ? request.suite.title : request.title;
      const bool one_rig =
          request.suite.name == "check" && !is_external(request.suite.rigs.front().spec);
      print_character(one_rig ? title + ". Your own rig: --baked CLIP" : title, facts,
                      request.baseline.has_value());
    };
  }
  if (options.output == kNoFolder) {
    request.folder.clear();
    Progress progress(common.progress_style());
    const Report report = run_suite(request, progress);
    progress.finish();
    if (!options.history.empty())
      append_night(options.history, night_of(report, request.today, request.label));
    return print_report(report, {}, common);
  }
  if (request.folder.empty()) request.folder = new_run_folder(options.output);
  const FolderTrace trace(request.folder);
  OutputFolder(request.folder).prepare();
  const FolderLock lock(request.folder, FolderLock::Kind::exclusive);
  if (request.ledger) {
    // The folder's own files, and those of ours below it; what else a user keeps there is not
    // searched.
    remove_leftovers(request.folder, false);
    for (const char* each : {"findings", "frames", "media", "meshes", "parts", "review"})
      remove_leftovers(request.folder / each);
  }
  leave_out_this_night(request);
  // A history's line tells of the results, whether or not they are kept for other nights: a night
  // that was cut into shards leaves the line that it leaves in one.
  if (!options.history.empty() && !request.carry) {
    CarryOver::Place place;
    place.history = options.history;
    place.fresh = true;
    place.keeps = false;
    request.carry = std::make_shared<CarryOver>(std::move(place));
  }
  Progress progress(common.progress_style());
  const Report report = run_suite(request, progress);
  progress.finish();
  const int code =
      publish(report, request.folder, options.output.empty(), common, options.single_file);
  if (!options.history.empty()) {
    const std::string hash = content_hash(read_bytes(request.folder / "report.json"));
    Night night = night_of(report, request.today, request.label, hash);
    night.results = request.carry->results_hash();
    append_night(options.history, night);
    request.carry->keep(request.folder, hash);
  }
  return code;
}

/// What standard output can show: width and colour of a terminal, plain text elsewhere.
TerminalStyle style_of_stdout() {
  TerminalStyle style;
  const char* no_color = std::getenv("NO_COLOR");
  const char* terminal = std::getenv("TERM");
  winsize size = {};
  if (isatty(STDOUT_FILENO) == 1) {
    if (ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0) style.width = size.ws_col;
    style.color = (no_color == nullptr || *no_color == '\0') && terminal != nullptr &&
                  std::string_view(terminal) != "dumb";
  }
  style.unicode = false;
  return style;
}

namespace {

int run_shard(RunRequest request, const Common& common, const Shard& shard, const JobPlan& plan) {
  OutputFolder(request.folder).prepare();
  const FolderLock lock(request.folder, FolderLock::Kind::shared);
  keep_plan(plan, request.folder);
  request.ledger =
      std::make_shared<Ledger>(request.folder, plan.stamp, Ledger::Mode::shard, shard, true);
  Progress progress(common.progress_style());
  run_suite(request, progress);
  progress.finish();
  const std::string share = std::to_string(shard.index) + "/" + std::to_string(shard.count);
  if (common.json) {
    std::printf("{\"shard\": \"%s\"}\n", share.c_str());
  } else {
    std::printf("shard %s is done; when all shards are done: backbend merge %s\n", share.c_str(),
                visible(request.folder.string()).c_str());
  }
  return kExitOk;
}

}  // namespace

int print_estimate(const RunRequest& request, const Common& common) {
  const JobEstimate job = estimate(request);
  if (common.json) {
    std::printf(
        "{\"canaries\": %zu, \"characters\": %zu, \"mappings\": %zu, \"minutes\": %s, "
        "\"pictures\": %zu, \"poses\": %zu, \"rigs\": %zu, \"searched\": %zu, "
        "\"small_pictures\": %zu, \"sweeps\": %zu}\n",
        job.canaries, job.characters, job.mappings, number_text(job.minutes, 2).c_str(),
        job.pictures, job.poses, job.rigs, job.searched, job.small_pictures, job.sweeps);
    return kExitOk;
  }
  std::printf("characters %zu, rigs %zu, canaries %zu, mappings %zu, sweeps %zu\n", job.characters,
              job.rigs, job.canaries, job.mappings, job.sweeps);
  std::printf("poses      %zu to measure\n", job.poses);
  if (job.searched > 0)
    std::printf("search     %zu poses between the sweeps, and those of finds\n", job.searched);
  std::printf("pictures   %zu small ones for image metrics, %zu rendered, and those of findings\n",
              job.small_pictures, job.pictures);
  std::printf("time       about %s minutes on this machine\n", minutes_text(job.minutes).c_str());
  return kExitOk;
}

int merge_runs(const std::vector<std::string>& runs, const std::string& output,
               const Common& common) {
  const fs::path target = output.empty() ? runs.front() : output;
  const JobPlan plan = read_plan(runs.front());
  NightlyOptions options = nightly_options(plan.arguments);
  RunRequest request = options.request();
  for (fs::path& file : request.suite.characters) file = plan.folder / file;
  if (job_stamp(request, stamped_words(plan.arguments)) != plan.stamp) {
    throw MixedPartsError(runs.front() +
                          ": its suite, a character or this program has changed since the shards "
                          "ran; run them again");
  }
  {
    OutputFolder(target).prepare();
    const FolderLock lock(target, FolderLock::Kind::exclusive);
    for (const std::string& run : runs) {
      if (read_plan(run).stamp != plan.stamp)
        throw MixedPartsError(run + ": holds shards of another job than " + runs.front());
    }
    keep_plan(plan, target);
    for (const std::string& run : runs) gather_parts(run, target, plan.stamp);
  }
  request.folder = target;
  request.ledger = std::make_shared<Ledger>(target, plan.stamp, Ledger::Mode::merge, Shard{}, true);
  const auto ledger = request.ledger;
  options.output = target.string();
  try {
    return run_and_print(std::move(request), common, options);
  } catch (const IncompleteError&) {
    for (const std::string& unit : ledger->missing())
      std::fprintf(stderr, "missing: %s\n", visible(unit).c_str());
    throw;
  }
}

void add_nightly(const Registry& registry) {
  struct Options : NightlyOptions {
    std::string shard;
    bool resume = false, dry_run = false, fresh = false;
    CLI::App* command = nullptr;
  };
  auto options = std::make_shared<Options>();
  CLI::App* command = registry.add(
      "nightly", "run a suite: the nightly comparison of rigs, with its report",
      [options, &common = registry.common] {
        if (options->output == kNoFolder)
          throw CLI::ValidationError("-o -: a night needs a run folder");
        const bool in_parts = options->resume || !options->shard.empty();
        if (in_parts && options->output.empty())
          throw CLI::ValidationError("--shard and --resume need the run folder: -o DIR");
        std::optional<Shard> shard;
        if (!options->shard.empty()) shard = shard_of(options->shard);
        // A night without a folder of its own is one of many: it belongs to their history.
        if (options->history.empty() && options->output.empty())
          options->history = "runs/history.jsonl";
        RunRequest request = options->request();
        if (options->dry_run) return print_estimate(request, common);
        request.folder = options->output;
        const std::vector<std::string> words = job_arguments(*options->command, options->suite);
        const std::string stamp = job_stamp(request, stamped_words(words));
        if (shard)
          return run_shard(std::move(request), common, *shard, {words, fs::current_path(), stamp});
        if (request.folder.empty()) request.folder = new_run_folder("");
        request.ledger = std::make_shared<Ledger>(request.folder, stamp, Ledger::Mode::alone,
                                                  Shard{}, options->resume);
        if (!options->history.empty()) {
          CarryOver::Place place;
          place.history = options->history;
          place.results = request.history_results;
          place.inputs = night_inputs(request.suite, stamped_words(words));
          for (const std::string& word : stamped_words(words)) place.options += word + "\n";
          place.today = request.today;
          place.label = options->label;
          place.fresh = options->fresh;
          place.keeps = !options->resume;
          request.carry = std::make_shared<CarryOver>(std::move(place));
        }
        const fs::path folder = request.folder;
        const int code = run_and_print(std::move(request), common, *options);
        // Parts serve a run that was stopped; this one is whole.
        if (!options->resume) remove_parts(folder);
        return code;
      });
  options->command = command;
  options->add_to(command);
  command->add_option("--shard", options->shard,
                      "run one share of the job: I/N, or 'auto' in a Slurm array; then merge");
  command->add_flag("--resume", options->resume,
                    "continue an earlier run in the folder; finished parts are verified and kept");
  command->add_flag("--dry-run", options->dry_run,
                    "print the plan and the estimated time, then exit");
  command->add_flag("--fresh", options->fresh,
                    "measure all again, also what has not changed since an earlier night");
}

namespace {

WatchedRun watched_run(const RunOptions& options, bool poll) {
  WatchedRun run;
  run.output = options.output;
  run.pictures = !options.quick;
  run.single_file = options.single_file;
  run.poll = poll;
  if (!options.baseline.empty()) run.inputs.emplace_back(options.baseline);
  return run;
}

WatchedRun watched_check(RunRequest request, const std::string& rig, const RunOptions& options,
                         bool poll) {
  WatchedRun run = watched_run(options, poll);
  for (fs::path& file : input_files(request.suite.characters.front()))
    run.inputs.push_back(std::move(file));
  if (fs::path(rig).extension() == ".toml") run.inputs.emplace_back(rig);
  for (const RigPlan& plan : request.suite.rigs)
    if (is_external(plan.spec))
      for (const std::string& file : external_files(plan.spec)) run.inputs.emplace_back(file);
  run.judge = [request = std::move(request)](const fs::path& folder, bool pictures,
                                             const std::shared_ptr<KnownJumps>& known_jumps,
                                             Progress& progress) {
    RunRequest each = request;
    each.folder = folder;
    each.known_jumps = known_jumps;
    each.image_pass = each.image_pass && pictures;
    each.suite.pictures.enabled = each.suite.pictures.enabled && pictures;
    return run_suite(each, progress);
  };
  return run;
}

WatchedRun watched_clip(const BakedOptions& baked, const std::string& character,
                        const RunOptions& options, bool poll) {
  WatchedRun run = watched_run(options, poll);
  for (const std::string& name : {character, baked.clip}) {
    if (name.empty()) continue;
    for (fs::path& file : input_files(name)) run.inputs.push_back(std::move(file));
  }
  PicturePlan plan;
  options.apply_to(plan);
  run.judge = [baked, character, hints = options.hints, plan](const fs::path& folder, bool pictures,
                                                              const std::shared_ptr<KnownJumps>&,
                                                              Progress&) {
    Common silent;
    silent.quiet = true;
    silent.json = true;  // says nothing of the character
    PicturePlan each = plan;
    each.enabled = each.enabled && pictures;
    return baked_report(baked, character, hints, silent, folder, each);
  };
  return run;
}

std::vector<std::string> envelope_choices() {
  std::vector<std::string> names = envelope_names();
  names.insert(names.begin(), kEnvelopeByKind);
  return names;
}

}  // namespace

void add_check(const Registry& registry) {
  struct Options : RunOptions {
    std::string character, rig = "even", mapping = "chest", envelope = kEnvelopeByKind,
                           sweeps = "standard", chain;
    BakedOptions baked;
    ExternalOptions external;
    bool dry_run = false, watch = false, poll = false;
  };
  auto options = std::make_shared<Options>();
  CLI::App* command = registry.add(
      "check", "judge one character under a rig, or the motion of its own rig",
      [options, &common = registry.common] {
        if (!options->baked.clip.empty() && options->dry_run)
          throw CLI::ValidationError("--dry-run: not available with --baked");
        if (options->watch && (options->dry_run || !options->history.empty()))
          throw CLI::ValidationError("--watch goes with neither --dry-run nor --history");
        if (options->watch && options->output == kNoFolder)
          throw CLI::ValidationError("-o -: --watch needs a run folder");
        if (options->poll && !options->watch) throw CLI::ValidationError("--poll needs --watch");
        if (!options->baked.clip.empty() && options->watch)
          return watch(watched_clip(options->baked, options->character, *options, options->poll),
                       common);
        if (!options->baked.clip.empty()) {
          PicturePlan pictures;
          options->apply_to(pictures);
          return check_baked(options->baked, options->character, options->hints, options->output,
                             pictures, common);
        }
        if (options->character.empty())
          throw CLI::RequiredError("a character file, or --baked with a clip");
        const CheckWishes wishes{options->character,
                                 options->external.read_rig(options->rig),
                                 *find_mapping(options->mapping),
                                 options->envelope,
                                 options->sweeps,
                                 options->chain,
                                 options->hints};
        RunRequest request = check_request(wishes);
        request.envelope_yields = common.from_project.contains("envelope");
        options->apply_to(request);
        if (options->dry_run) return print_estimate(request, common);
        if (options->watch)
          return watch(watched_check(std::move(request), options->rig, *options, options->poll),
                       common);
        return run_and_print(std::move(request), common, *options);
      });
  command
      ->add_option("character", options->character,
                   "character file: .glb, .gltf, or a body description .toml")
      ->type_name(kFileType);
  add_baked_options(command, options->baked);
  command->add_option("--rig", options->rig, kRigHelp)->type_name(kRigType)->configurable();
  add_mapping_option(command, options->mapping)->configurable();
  command
      ->add_option("--envelope", options->envelope,
                   "required range: human, animal, long_neck, snake, neck, cartoon, creature, "
                   "sweep, or auto for that of the kind of body [auto]")
      ->check(CLI::IsMember(envelope_choices()))
      ->configurable();
  options->external.add_to(command);
  add_chain_option(command, options->chain);
  command->add_option("--sweeps", options->sweeps, "standard or stress [standard]")
      ->check(CLI::IsMember({"standard", "stress"}))
      ->configurable();
  command->add_flag("--dry-run", options->dry_run,
                    "print the plan and the estimated time, then exit");
  command->add_flag("--watch", options->watch,
                    "judge again whenever an input changes, until Ctrl-C");
  command->add_flag(
      "--poll", options->poll,
      "with --watch: look at the files twice a second, where the system does not tell "
      "of changes (network folders do so by themselves)");
  options->add_to(command);
}

}  // namespace backbend::cli
