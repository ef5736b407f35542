#pragma once
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "validate/verdicts/finding.h"
#include "validate/verdicts/limits.h"

namespace backbend::validate {

/// A finding that somebody has accepted for a while. Empty fields match everything.
struct Waiver {
  std::string code;  // required
  std::string character, rig, sweep, joint;
  double from_deg = -std::numeric_limits<double>::infinity();  // of the control
  double to_deg = std::numeric_limits<double>::infinity();
  double worst = std::numeric_limits<double>::quiet_NaN();  // not worse than this; NaN: any
  std::string owner, reason;                                // required
  std::string expires;  // `2026-12-15`, the last day it holds; required
  std::string origin;   // file and line
};

/// Whether a text is a day of the Gregorian calendar, `2026-12-15`.
bool is_day(std::string_view text);

/// Days from one day to another, negative where that is past. Both must be days (is_day).
int days_between(std::string_view from, std::string_view to);

/// Throws LimitError (naming the origin) for an unknown code, a missing owner or reason, a day that
/// does not exist, or an empty range.
void check_waiver(const Waiver& waiver);

/// Whether a waiver speaks of a finding, whatever the day.
bool covers(const Waiver& waiver, const Finding& finding);

/// What waivers did to the findings of a run.
struct WaiverUse {
  std::size_t waived = 0;
  std::vector<std::size_t> holding;  // into the waivers: they cover a failure, and it is waived
  std::vector<std::size_t> expired;  // into the waivers: they cover a failure and no longer hold
  std::vector<std::size_t> unused;   // they cover nothing any more, and can go
};

/// Turns failures that a waiver covers into `waived`; an expired waiver changes nothing and is
/// named. `today`: a day, given by the caller, for nothing here looks at a clock.
WaiverUse apply_waivers(std::span<Finding> findings, std::span<const Waiver> waivers,
                        std::string_view today);

}  // namespace backbend::validate
