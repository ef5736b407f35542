#include <cstdio>
#include <cstdlib>
#include <ctime>

#include "cli/commands.h"
#include "cli/settings.h"
#include "validate/files/hash.h"
#include "validate/files/output_folder.h"
#include "validate/history/baseline.h"
#include "validate/model/report_json.h"

namespace backbend::cli {

using namespace backbend::validate;
namespace fs = std::filesystem;

namespace {

struct Options {
  std::string file, run = "runs/latest", baseline = "baseline.json", author, reason, until;
};

/// Hash of a picture in the run's folder; empty where it is missing or its path leaves the folder.
std::string hash_of_picture(const fs::path& folder, const std::string& name) {
  const fs::path path(name);
  if (path.is_absolute()) return "";
  for (const fs::path& part : path)
    if (part == "..") return "";
  std::error_code none;
  return fs::is_regular_file(folder / path, none) ? content_hash(read_bytes(folder / path)) : "";
}

int approve_run(const Options& options, const Common& common) {
  fs::path report_file = options.run;
  if (fs::is_directory(report_file)) report_file /= "report.json";
  const Report report = parse_report(read_text(report_file), report_file.string());
  Approvals approvals = options.file.empty()
                            ? approvals_of_all(report)
                            : parse_approvals(read_text(options.file), options.file);
  // The command line overrides what the page wrote.
  if (!options.author.empty()) approvals.author = options.author;
  if (!options.reason.empty()) approvals.reason = options.reason;
  if (!options.until.empty()) approvals.until = options.until;
  if (approvals.author.empty() && std::getenv("USER") != nullptr)
    approvals.author = std::getenv("USER");
  const fs::path file(options.baseline);
  Baseline before;
  if (fs::exists(file)) before = parse_baseline(read_text(file), file.string());
  const Baseline after =
      approve(before, report, approvals, today(), [&](const std::string& picture) {
        return hash_of_picture(report_file.parent_path(), picture);
      });
  OutputFolder(file.parent_path()).write(file.filename(), baseline_json(after));
  if (!common.quiet) {
    std::fprintf(stderr, "%zu approved in %s; from now on --baseline fails on new or worse\n",
                 approvals.cases.size(), file.c_str());
  }
  return 0;
}

}  // namespace

std::string today() {
  const std::time_t now = std::time(nullptr);
  std::tm local = {};
  localtime_r(&now, &local);
  char text[80];
  std::snprintf(text, sizeof text, "%04d-%02d-%02d", local.tm_year + 1900, local.tm_mon + 1,
                local.tm_mday);
  return text;
}

void add_approve(const Registry& registry) {
  auto options = std::make_shared<Options>();
  CLI::App* command =
      registry.add("approve", "approve a run's failures: from then on only new or worse ones fail",
                   [options, &common = registry.common] { return approve_run(*options, common); });
  command->add_option("file", options->file,
                      "approvals written by the report's page [every failure of the run]");
  command->add_option("--run", options->run, "the run's folder or report.json [runs/latest]");
  command->add_option("--baseline", options->baseline, "baseline to update [baseline.json]")
      ->type_name(kFileType)
      ->configurable();
  command->add_option("--reason", options->reason, "why; needed, unless the file says it");
  command->add_option("--until", options->until, "last day it holds, like 2026-12-15 [no end]");
  command->add_option("--author", options->author, "who [the file's, or the user's name]")
      ->configurable();
}

}  // namespace backbend::cli
