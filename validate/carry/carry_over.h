#pragma once
#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "validate/model/report.h"
#include "validate/sweeps/suite.h"

namespace backbend::validate {

/// What all results of a night depend on but for its characters: this very program with the
/// libraries that run with it, the options, and what the suite says of rigs, sweeps, limits and
/// pictures. Which characters it has, what it is called, its waivers and its planted faults count
/// elsewhere. Throws ReadError, SuiteError.
std::string night_inputs(const Suite& suite, const std::vector<std::string>& options);

/// This very program and the libraries that run with it.
std::string program_inputs();

/// What a character's files hold: its own, those that a .gltf names, and its sidecar. Throws
/// ReadError where the character cannot be read.
std::string character_content(const std::filesystem::path& character);

/// Results of earlier nights that hold for tonight, too.
///
/// A unit of work is a character of a suite, or its planted faults. Its result is a report of that
/// alone with the names and hashes of the files that were made for it, kept in `carried/` beside
/// the history, one file for each unit, with the hashes of all results of its night. It counts for
/// a night with the same inputs (`stamp`) if all of this is right: the entry's own hash; a night of
/// the history has the report that it is from and these results, and that report is in its run's
/// folder as the history knows it; the result is one of them; every file has its hash. Other inputs
/// count as no result. Damage counts as no result and gives a warning.
class CarryOver {
 public:
  struct Place {
    std::filesystem::path history;  // its file
    // Of its nights: the hash of each one's report -> results_hash() of it.
    std::map<std::string, std::string> results;
    std::string inputs;        // night_inputs()
    std::string options;       // in words: nights of other options do not displace these
    std::string today, label;  // of tonight
    bool fresh = false;        // finds nothing, keeps all
    bool keeps = true;         // false for a run that takes up another: its files are older
  };
  explicit CarryOver(Place place);

  /// The result of a unit.
  struct Result {
    Report report;
    std::string night;                         // that measured it: `2026-11-22 v013`
    std::map<std::string, std::string> files;  // name below the run folder -> content hash
    std::string text{};  // of the report, as entries have it; empty: none has it yet
  };

  /// Reads what is kept of these units (with their stamps) side by side, for find() to take up.
  void read_ahead(const std::vector<std::pair<std::string, std::string>>& units);

  /// What an earlier night found, its files put into the run folder as links or copies.
  /// `most_days`: older than so many days it does not count; 0: whatever its age. `fits`: whether
  /// tonight's report can take it. `complain` is told of what is damaged. Throws WriteError.
  std::optional<Result> find(const std::string& unit, const std::string& stamp,
                             const std::filesystem::path& folder, int most_days,
                             const std::function<bool(const Report&)>& fits,
                             const std::function<void(const std::string&)>& complain);

  /// Notes a result of tonight, or one that was found, to be kept.
  void note(const std::string& unit, const std::string& stamp, Result result);

  /// Of all that was noted: what the history's line of tonight holds.
  std::string results_hash() const;

  /// Keeps what was noted, once the night's report is in its folder and in the history. Hashes the
  /// files that have none. Throws WriteError.
  void keep(const std::filesystem::path& folder, const std::string& report_hash) const;

  const Place& place() const { return place_; }
  /// Tonight, as marks call it.
  std::string tonight() const;

 private:
  struct Noted {
    std::string stamp;
    Result result;
  };
  /// A result that its night had; its files were not looked at.
  struct Entry {
    std::optional<Result> result;
    std::filesystem::path run;  // its night's folder
    std::string complaint;      // the warning, if the entry is damaged
  };
  std::filesystem::path entry_file(const std::string& unit) const;
  Entry read(const std::string& unit, const std::string& stamp) const;
  /// Whether a night's report is still what the history knows.
  bool is_unchanged(const std::filesystem::path& report, const std::string& hash) const;
  /// The hash of each unit's result, as JSON.
  std::string results_text() const;

  Place place_;
  mutable std::map<std::pair<std::filesystem::path, std::string>, bool> unchanged_;
  mutable std::mutex looking_at_reports_;
  std::map<std::pair<std::string, std::string>, Entry> ahead_;  // by unit and stamp
  std::map<std::string, Noted> noted_;                          // by unit
};

/// The files of a run folder that show results, by name below it, with what tells a file from the
/// one that takes its place.
using FolderListing = std::map<std::string, std::array<std::int64_t, 3>>;
FolderListing list_results(const std::filesystem::path& folder);
/// The files that are new in `after`, or took another's place.
std::map<std::string, std::string> files_made(const FolderListing& before,
                                              const FolderListing& after);

}  // namespace backbend::validate
