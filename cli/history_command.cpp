#include <algorithm>
#include <cstdio>
#include <ctime>
#include <nlohmann/json.hpp>

#include "cli/commands.h"
#include "cli/settings.h"
#include "solver/rig/nearest_name.h"
#include "validate/files/output_folder.h"
#include "validate/history/history_index.h"
#include "validate/history/history_text.h"
#include "validate/history/trend.h"
#include "validate/model/report_json.h"
#include "validate/verdicts/waivers.h"

namespace backbend::cli {

using namespace backbend::validate;
namespace fs = std::filesystem;

namespace {

struct HistoryOptions {
  std::string file = "runs/history.jsonl", add, date, label, suite, character, rig, metric;
  std::vector<std::string> first_bad;
  int nights = static_cast<int>(kTrendNights);
};

int add_run(const HistoryOptions& options, const Common& common) {
  fs::path report = options.add;
  if (fs::is_directory(report)) report /= "report.json";
  const std::string date = options.date.empty() ? today() : options.date;
  if (!is_day(date))
    throw CLI::ValidationError("--date '" + date + "': invalid day; expected one like 2026-11-22");
  const Night night =
      night_of(parse_report(read_text(report), report.string()), date, options.label);
  const bool added = append_night(options.file, night);
  if (!common.quiet)
    std::fprintf(stderr, "%s %s\n", added ? "added to" : "already the last night of",
                 options.file.c_str());
  return 0;
}

int print_first_bad(const HistoryOptions& options, const HistoryIndex& history) {
  const std::string& character = options.first_bad[0];
  const std::string& code = options.first_bad[1];
  const std::vector<std::string> names = history.characters();
  if (std::find(names.begin(), names.end(), character) == names.end()) {
    throw CLI::ValidationError("no night has a character '" + character + "'" +
                               solver::did_you_mean(character, names));
  }
  const std::vector<Night> nights = history.nights_of(character, code);
  const auto onset = first_bad(nights, character, code);
  if (onset) {
    std::fputs(onset_text(character, code, *onset, style_of_stdout()).c_str(), stdout);
  } else {
    std::printf("%s never failed on %s\n", code.c_str(), character.c_str());
  }
  return 0;
}

nlohmann::json json_of(const TrendTable& table) {
  nlohmann::json trends = nlohmann::json::array();
  for (const Trend& t : table.trends) {
    nlohmann::json steps = nlohmann::json::array();
    for (const TrendStep& s : t.steps) {
      steps.push_back({{"version", s.version},
                       {"last_before", s.last_before},
                       {"before", s.before},
                       {"after", s.after},
                       {"worse", s.worse},
                       {"recovered", s.recovered}});
    }
    trends.push_back({{"character", t.character},
                      {"rig", t.rig},
                      {"mapping", t.mapping},
                      {"metric", t.metric},
                      {"unit", t.unit},
                      {"value", t.value},
                      {"steps", steps}});
  }
  return {{"schema", "backbend.history/1"}, {"nights", table.nights}, {"trends", trends}};
}

int print_history(const HistoryOptions& options, const Common& common,
                  const HistoryIndex& history) {
  // The last night's suite, unless another is asked for.
  const std::string suite = options.suite.empty() ? history.last_suite() : options.suite;
  const auto most = static_cast<std::size_t>(options.nights);
  const TrendTable table =
      trends_of(history.last_nights(suite, most, {options.character, options.rig, options.metric}),
                suite, most);
  if (common.json)
    std::printf("%s\n", json_of(table).dump(2).c_str());
  else
    std::fputs(history_text(table, style_of_stdout()).c_str(), stdout);
  return 0;
}

}  // namespace

void add_history(const Registry& registry) {
  auto options = std::make_shared<HistoryOptions>();
  CLI::App* command =
      registry.add("history", "show each metric over the nights, and since when a check fails",
                   [options, &common = registry.common] {
                     if (!options->add.empty()) return add_run(*options, common);
                     const HistoryIndex history(options->file);
                     if (!options->first_bad.empty()) return print_first_bad(*options, history);
                     return print_history(*options, common, history);
                   });
  command->add_option("--history,--file", options->file, "the history [runs/history.jsonl]")
      ->type_name(kFileType)
      ->configurable();
  command->add_option("--add", options->add, "add a run folder or report.json as a night");
  command->add_option("--date", options->date, "date of --add, like 2026-11-22 [today]");
  command->add_option("--label", options->label, "version label for --add, like v013");
  command->add_option("--suite", options->suite, "suite to show [the last night's]");
  command->add_option("--character", options->character, "show only this character");
  command->add_option("--rig", options->rig, "show only this rig");
  command->add_option("--metric", options->metric, "show only this metric");
  command->add_option("--nights", options->nights, "number of nights to show [90]")
      ->check(CLI::Range(1, 3660))
      ->configurable();
  command
      ->add_option("--first-bad", options->first_bad,
                   "CHARACTER CODE: the version where the check began to fail")
      ->expected(2);
}

}  // namespace backbend::cli
