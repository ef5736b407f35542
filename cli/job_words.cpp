#include <algorithm>
#include <array>
#include <filesystem>
#include <string_view>

#include "cli/nightly.h"

namespace backbend::cli {
namespace {

namespace fs = std::filesystem;

/// Options that do not affect a job's results.
constexpr std::array<std::string_view, 8> kHow = {"--output", "--shard",  "--resume", "--dry-run",
                                                  "--shards", "--submit", "--help",   "--fresh"};
/// Options that the report alone depends on, and those of them that name a file.
constexpr std::array<std::string_view, 4> kOfReport = {"--baseline", "--history", "--label",
                                                       "--single-file"};
constexpr std::array<std::string_view, 2> kFilesOfReport = {"--baseline", "--history"};

template <std::size_t N>
bool is_one_of(std::string_view name, const std::array<std::string_view, N>& names) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

std::string whole_path(const std::string& file) {
  return fs::absolute(file).lexically_normal().string();
}

}  // namespace

std::vector<std::string> job_arguments(const CLI::App& command, const std::string& suite) {
  std::vector<std::string> words;
  for (const CLI::Option* option : command.get_options()) {
    const std::string name = option->get_name();
    if (option->count() == 0 || option->get_positional() || is_one_of(name, kHow)) continue;
    if (option->get_items_expected_max() == 0) {
      // `--quick=false` overrides a project; without one it equals the default.
      if (option->reduced_results().back() != "false") words.push_back(name);
      continue;
    }
    for (const std::string& value : option->results())
      words.push_back(name + "=" + (is_one_of(name, kFilesOfReport) ? whole_path(value) : value));
  }
  if (!suite.empty()) words.push_back(whole_path(suite));
  return words;
}

std::vector<std::string> stamped_words(const std::vector<std::string>& arguments) {
  std::vector<std::string> words;
  for (const std::string& word : arguments) {
    if (word.starts_with("--") && !is_one_of(word.substr(0, word.find('=')), kOfReport))
      words.push_back(word);
  }
  return words;
}

NightlyOptions nightly_options(const std::vector<std::string>& arguments) {
  CLI::App app;
  app.option_defaults()->multi_option_policy(CLI::MultiOptionPolicy::TakeLast);
  NightlyOptions options;
  options.add_to(&app);
  app.parse(std::vector<std::string>(arguments.rbegin(), arguments.rend()));
  return options;
}

}  // namespace backbend::cli
