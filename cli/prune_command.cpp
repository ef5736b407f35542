#include <algorithm>
#include <cstdio>

#include "cli/commands.h"
#include "validate/files/output_folder.h"
#include "validate/model/report_json.h"
#include "validate/tasks/progress.h"
#include "validate/verdicts/waivers.h"

namespace backbend::cli {

using namespace backbend::validate;
namespace fs = std::filesystem;

namespace {

/// The large files of a run's folder; the report in all its forms is small and is kept.
constexpr const char* kHeavy[] = {"findings", "frames", "media", "meshes", "review"};

/// A folder that a run named by itself (runs/2026-11-22_031500) and that holds its report. Nothing
/// else is ever touched.
bool is_run(const fs::path& folder) {
  const std::string name = folder.filename().string();
  return !fs::is_symlink(folder) && fs::is_directory(folder) && name.size() >= 17 &&
         is_day(name.substr(0, 10)) && name[10] == '_' &&
         fs::is_regular_file(folder / "report.json");
}

std::uintmax_t bytes_under(const fs::path& folder) {
  std::uintmax_t bytes = 0;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file() && !entry.is_symlink()) bytes += entry.file_size();
  return bytes;
}

int prune(const fs::path& runs, std::size_t keep, bool dry_run) {
  if (!fs::is_directory(runs)) throw ReadError(runs.string() + ": no such folder of runs");
  std::vector<fs::path> folders;
  for (const auto& entry : fs::directory_iterator(runs))
    if (is_run(entry.path())) folders.push_back(entry.path());
  // Their names sort by time.
  std::sort(folders.begin(), folders.end());
  folders.resize(folders.size() - std::min(folders.size(), keep));
  std::error_code none;
  const fs::path latest = fs::weakly_canonical(runs / "latest", none);
  for (const fs::path& folder : folders) {
    poll_interrupt();
    if (fs::weakly_canonical(folder, none) == latest) continue;
    std::uintmax_t bytes = 0;
    for (const char* name : kHeavy) {
      const fs::path heavy = folder / name;
      if (fs::is_symlink(heavy) || !fs::is_directory(heavy)) continue;
      bytes += bytes_under(heavy);
      std::error_code error;
      if (!dry_run) fs::remove_all(heavy, error);
      if (error)
        throw WriteError(heavy.string() + ": cannot be removed: " + error.message(), error.value());
    }
    if (bytes > 0)
      std::printf("%s  %.1f MB of pictures%s\n", folder.c_str(), static_cast<double>(bytes) / 1e6,
                  dry_run ? " would go" : " removed");
  }
  return 0;
}

}  // namespace

void add_prune(const Registry& registry) {
  struct Options {
    std::string runs = "runs";
    int keep = 14;
    bool dry_run = false;
  };
  auto options = std::make_shared<Options>();
  CLI::App* command = registry.add(
      "prune", "delete the pictures of old runs; reports, history and numbers are kept", [options] {
        return prune(options->runs, static_cast<std::size_t>(options->keep), options->dry_run);
      });
  command->add_option("runs", options->runs, "folder of runs [runs]");
  command->add_option("--keep", options->keep, "number of newest runs to keep whole [14]")
      ->check(CLI::Range(0, 100000))
      ->configurable();
  command->add_flag("--dry-run", options->dry_run, "list what would be deleted; delete nothing");
}

}  // namespace backbend::cli
