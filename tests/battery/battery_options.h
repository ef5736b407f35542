#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace backbend::battery {

/// The options that batteries share.
struct BatteryOptions {
  std::string program;  // for messages
  std::uint64_t seed = 1, shard = 0, shards = 1;
  std::string lines, keep;       // files to append a line of each case to; folder to keep cases in
  std::vector<std::string> sum;  // files of such lines, to print the tables of, and run nothing
  std::filesystem::path characters;

  /// The lines of all files in `sum`.
  std::vector<nlohmann::json> lines_to_sum() const;
  /// Prints why and ends the program with 2.
  [[noreturn]] void usage(const std::string& why) const;
};

/// Takes an option of the battery's own, with its value; false where it has none of that name.
using TakeOption = std::function<bool(const std::string& word, const std::string& value)>;

BatteryOptions read_battery_options(const std::string& program, int argc, char** argv,
                                    const TakeOption& own);

/// A whole number from an option's value.
std::uint64_t number_of(const std::string& value);

/// Prints that there are no characters, and gives the exit code of a skipped test.
int skipped_for_want_of_characters();

}  // namespace backbend::battery
