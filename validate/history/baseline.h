#pragma once
#include <filesystem>
#include <functional>
#include <map>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "validate/model/report.h"

namespace backbend::validate {

/// A baseline or approvals file that cannot be used, or approvals that do not belong to the run.
/// what() is the whole line.
struct BaselineError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A baseline was asked for and is not there (exit code 6).
struct NoBaseline : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// One failure that somebody has looked at and accepted, as bad as it was and no worse.
struct Approval {
  std::string code, character, rig, mapping, sweep, joint;
  double value = 0;
  std::string unit;
  std::map<std::string, std::string> pictures;  // `before`, `heat` ... -> content hash
  std::string author, reason, date;             // date: `2026-11-22`
  std::string until;                            // the last day it holds; empty: no end
  std::string report;                           // content hash of the report it was approved from
};

/// What is approved for one suite. A case may have several approvals; any one that holds suffices.
struct Baseline {
  std::string suite;
  std::vector<Approval> approvals;
};

/// The baseline as JSON text, schema `backbend.baseline/1`, one approval a line so that versions of
/// it compare line by line. `parse_baseline(baseline_json(b))` gives b.
std::string baseline_json(const Baseline& baseline);
/// Throws BaselineError for anything else. `name` is what errors call the text.
Baseline parse_baseline(std::string_view text, std::string_view name);

/// The ratchet: failures of proposed rigs that an approval covers become `waived` and say by whom
/// and until when; what is worse than approved, or whose approval has expired, stays a failure and
/// says so. A flip inside the envelope stays a failure whatever was approved. `today`: a day.
void apply_baseline(std::span<Finding> findings, const std::function<Role(const Finding&)>& role_of,
                    const Baseline& baseline, std::string_view today);

/// Who approves what, and why: the text of an approvals file that the report's page writes, schema
/// `backbend.approvals/1`.
struct Approvals {
  std::string report;  // content hash of the report that was looked at
  std::string suite, author, reason, until;
  struct Case {
    std::size_t finding = 0;  // into the report's findings
    std::string hash;         // of that finding, as finding_hash gives it
  };
  std::vector<Case> cases;
};
Approvals parse_approvals(std::string_view text, std::string_view name);

/// Every failure of proposed rigs in the report.
Approvals approvals_of_all(const Report& report);

/// The baseline with the approvals added; equal ones (same case, value and pictures) are replaced.
///
/// Refuses, with a BaselineError and nothing changed: approvals of another report or suite, a wrong
/// hash, a finding that is not there or did not fail, a flip inside the envelope, no author or
/// reason, an `until` that is no day or before `today`, a picture of the finding that is not in the
/// run's folder. `picture_hash`: content hash of a picture by its path, empty where it is missing.
Baseline approve(const Baseline& before, const Report& report, const Approvals& approvals,
                 std::string_view today,
                 const std::function<std::string(const std::string&)>& picture_hash);

}  // namespace backbend::validate
