#pragma once
#include <filesystem>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "validate/model/report.h"

namespace backbend::validate {

/// A history that cannot be used. what() names file, line, and what was expected.
struct HistoryError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// One number of one night: the worst value of a metric, or the headroom of a channel.
struct NightValue {
  std::string character, rig, mapping, metric;
  std::string unit;
  bool more_is_worse = true;
  double value = 0;  // NaN: not measured
};

/// That a check failed on a character that night, and how badly.
struct NightFailure {
  std::string character, rig, mapping, code, pose;
  double value = 0;
};

/// What is remembered of one run.
struct Night {
  std::string date;     // `2026-11-22`
  std::string label;    // what the user calls this version of the characters; may be empty
  std::string suite;    // runs of one suite make one history
  std::string report;   // content hash of its report.json
  std::string results;  // CarryOver::results_hash() of it; empty: unknown, as of older lines
  Verdict verdict = Verdict::not_measured;
  std::map<std::string, std::string> version;  // character -> content hash of its file
  std::vector<NightValue> values;              // of every rig but canaries
  std::vector<NightFailure> failures;          // of proposed rigs, the worst of each check
};

/// Lines of the first version are read as well; they take eight times the space.
inline constexpr std::string_view kNightSchemaName = "backbend.night/2",
                                  kFirstNightSchemaName = "backbend.night/1";

/// What a report leaves behind. `more_is_worse` of a metric by its name; true for unknown ones.
/// `report_hash`: that of the report's JSON, where it is known; nullopt: it is made.
Night night_of(const Report& report, const std::string& date, const std::string& label,
               const std::optional<std::string>& report_hash = {});

/// How the failures of the last night compare with the night of its suite before it: `2 of 3
/// failing checks are new since 2026-11-21 (v012)`. Empty where there is no such night, or neither
/// failed. A check that fails on a character under a rig counts once, whatever the pose.
std::string news_of(const std::vector<Night>& nights);

/// One line of JSON, without the line feed.
std::string night_json(const Night& night);

/// The inverse of many lines; `name` is what errors call the text. Throws HistoryError for a line
/// that is damaged (the last one too: a line without its line feed was cut short).
std::vector<Night> parse_history(std::string_view text, std::string_view name);

/// Adds one night at the end in one write, flushed to the medium; lines that are there are never
/// touched, and two writers do not mix. False where that report is the suite's last night already.
/// Throws HistoryError where the file is damaged, WriteError.
bool append_night(const std::filesystem::path& file, const Night& night);

}  // namespace backbend::validate
