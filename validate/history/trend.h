#pragma once
#include <optional>
#include <string>
#include <vector>

#include "validate/history/history.h"

namespace backbend::validate {

/// How many nights a report shows.
inline constexpr std::size_t kTrendNights = 90;

/// What a night is called: its date and, where it has one, its label.
std::string name_of(const Night& night);

struct TrendTable {
  std::vector<std::string> nights;  // oldest first
  std::vector<Trend> trends;
};

/// The series of every value of the last `nights` nights of a suite, with their steps, as a report
/// shows them: those that got worse first, then those that changed, then the steady ones. A step
/// for the worse that a later one undoes stays listed, with the night it recovered.
TrendTable trends_of(const std::vector<Night>& history, const std::string& suite,
                     std::size_t nights = kTrendNights);

/// Since when a check fails on a character.
struct Onset {
  const Night* first_bad = nullptr;  // of the last stretch of failures
  const Night* last_good = nullptr;  // the night before it; null where none was recorded
  const Night* recovered = nullptr;  // the first good night after it; null where it still fails
  std::size_t bad_nights = 0;        // in that stretch
  NightFailure worst;                // of the first bad night
};

/// The last stretch of nights on which `code` failed on `character`; nullopt where it never did.
std::optional<Onset> first_bad(const std::vector<Night>& history, const std::string& character,
                               const std::string& code);

}  // namespace backbend::validate
