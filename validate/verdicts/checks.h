#pragma once
#include <limits>
#include <span>
#include <string_view>

#include "validate/verdicts/finding.h"

namespace backbend::validate {

/// Which side of its limit a good value lies on.
enum class Sense { at_most, at_least };

/// What a check looks at, and so what it needs in order to run.
enum class Subject { chain, mesh, input, tool };

/// Which pictures a finding is held against (image_pass.h). `jump`: both of its sides, which are
/// shown, too.
enum class Witness { none, jump, kink, arms, slices };

/// A row of the one table of checks. `list checks`, `explain`, the report's legend and
/// docs/checks/README.md show it; a test compares the last row by row.
struct Check {
  std::string_view code;  // stable: BB001
  std::string_view name;  // short, lower case: `flip`
  Subject subject;
  std::string_view measures;  // what the value is, one sentence
  std::string_view unit;      // `deg`, `deg/deg`, `%`, `ratio`, `count`
  double limit;               // default; a studio, show or character may set its own
  Sense sense;
  bool decides;              // false: shown and counted, never part of the exit code
  std::string_view reason;   // why this limit
  Owner owner;               // who usually has to act
  std::string_view cause;    // what usually causes it
  std::string_view remedy;   // what to try
  std::string_view witness;  // what the picture is asked, empty where pictures cannot tell
  std::string_view source;   // where the formula comes from
  Witness pictures = Witness::none;
  /// The size of a fault that pictures showed on every calibrated body, with a margin, in the
  /// check's unit (docs/calibration.md); infinity where it was not calibrated.
  double always_seen = std::numeric_limits<double>::infinity();
};

/// All checks, by rising code.
std::span<const Check> all_checks();

/// The check with this code, or nullptr.
const Check* find_check(std::string_view code);

/// Judges a value of a check against a limit, the value to the four digits that reports print, so
/// that none fails that reads like its limit. A value or limit that is not finite is not_measured.
Verdict judge(const Check& check, double measured, double limit);

/// By how much a value misses its limit, as a factor of it: comparable between checks. Above 1 on
/// the failing side, whichever that is; finite for limits and values of 0.
double excess(const Check& check, double value, double limit);

/// Lower-case words for files and tables: `not measured` is `not_measured`, owners are upper case.
std::string_view name_of(Verdict verdict);
std::string_view name_of(Owner owner);
std::string_view name_of(Sense sense);
std::string_view name_of(Subject subject);

}  // namespace backbend::validate
