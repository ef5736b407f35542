#pragma once
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "validate/carry/carry_over.h"
#include "validate/files/ledger.h"
#include "validate/history/baseline.h"
#include "validate/history/history.h"
#include "validate/measure/known_jumps.h"
#include "validate/model/report.h"
#include "validate/stage/stage.h"
#include "validate/sweeps/suite.h"
#include "validate/tasks/progress.h"
#include "validate/verdicts/limits.h"

namespace backbend::validate {

/// What to run, and where its results go.
struct RunRequest {
  Suite suite;
  skin::AnatomyHints hints;
  DrivenChain chain = DrivenChain::spine;
  std::filesystem::path folder;      // run folder; empty: nothing is written
  bool image_pass = true;            // the cheap picture of every pose that image metrics look at
  std::string character;             // the file as the user named it; empty: the suite's own
  std::optional<Baseline> baseline;  // what is approved: only new or worse fails then
  std::optional<std::vector<Night>> history;           // earlier nights, for the report's trends
  std::map<std::string, std::string> history_results;  // of all nights of it: report -> results
  std::string label;                                   // label of this version in the history
  std::string today;       // `2026-11-22`; needed with either of the two, and for waivers to hold
  std::string calibrated;  // what the last whole calibration said; empty: not asked
  std::string title;       // first line of the report; empty: the suite's
  bool envelope_yields = false;  // the suite's envelope yields to that of a sidecar

  /// Which comparison the run is made for: its worst poses are photographed. `rigs`: the proposed
  /// rig against the reference; `characters`: the second character against the first, which is a
  /// reference then and does not decide.
  enum class Compare { none, rigs, characters };
  Compare compare = Compare::none;

  // Where finished work is kept and taken from; null: nowhere. Shard reports are partial and must
  // not be written.
  std::shared_ptr<Ledger> ledger;
  // Jumps of this character's rigs that an earlier run of this process found; null: none are kept.
  std::shared_ptr<KnownJumps> known_jumps;
  // Where results of earlier nights are taken from and tonight's noted; null: nowhere.
  std::shared_ptr<CarryOver> carry;

  /// Called as soon as a character is read, before anything is measured.
  std::function<void(const CharacterFacts&)> on_character;

  /// A character's file as reproduce lines name it: as it was typed, or from the folder of the
  /// suite that names it (the one above, where that is called `scenes`). It does not depend on the
  /// working folder, and is absolute only where the user typed it so.
  std::string character_text(const std::filesystem::path& file) const;
  /// The same, quoted for a shell, with the options that name joints as given here.
  std::string character_words(const std::filesystem::path& file) const;
};

/// Measures every rig of the suite on every character, judges it, and renders the evidence.
/// A character that cannot be used becomes a finding (BB051); the others are still run.
/// Throws Interrupted; WriteError where the run folder cannot be written; IncompleteError naming
/// what is missing where the ledger only merges.
Report run_suite(const RunRequest& request, Progress& progress);

/// A row for every check that the report's rigs planned, with the limit that applies.
std::vector<CheckLegend> legend(const Report& report, const LimitSet& limits);

/// How the report's page is written, and where its pictures are.
struct PageStyle {
  std::filesystem::path files;  // what the report's paths are relative to; empty: the folder
  bool single_file = false;     // embed every picture in the page
};

/// The report in every form (JSON, page, JUnit, Markdown, CSV, headline.txt and .png; in review/
/// angles.csv and the timelines of what has pictures) into the run's folder, the page last.
void write_report(const Report& report, const std::filesystem::path& folder,
                  const PageStyle& style = {});

}  // namespace backbend::validate
