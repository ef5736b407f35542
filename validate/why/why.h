#pragma once
#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "validate/tasks/progress.h"
#include "validate/verdicts/finding.h"
#include "validate/why/ingredients.h"

namespace backbend::validate {

/// How versions are judged: as `check` does, geometry only.
struct WhySettings {
  DrivenChain chain = DrivenChain::spine;
  solver::Mapping mapping = solver::Mapping::chest;
  std::string envelope;  // its name; empty: the sidecar's, else that of the kind of body
  std::map<std::string, double> limits;  // by code, where they are not the default
};

/// What `check` says of a version without pictures: the worst failing finding of each check in each
/// sweep, by `BB011 extension`.
using Failures = std::map<std::string, Finding>;
/// Throws skin::CharacterError, solver::RigError where the version cannot be measured; Interrupted.
Failures failures_of(const Version& version, const WhySettings& settings);

/// Keeps the worst of each key.
void add_failure(Finding finding, Failures& failures);

/// What runs of the two versions said, by whatever program measured them; null: no such run.
struct RecordedFailures {
  const Failures* before = nullptr;
  const Failures* after = nullptr;
  std::string programs;  // how the programs that measured them differ from this one
};

/// A finding that the later version has and the earlier has not, or not so badly, and what made it.
struct WhyFinding {
  std::string key;
  Finding finding;            // in the later version
  std::optional<double> was;  // its value in the earlier version, where it failed there too
  // The fewest ingredients that, taken from the later version, make it, and without which the later
  // version does not have it.
  IngredientSet ingredients = 0;
  std::vector<std::string> joints;      // whose weights did it, where weights did
  std::vector<std::uint32_t> vertices;  // of the later mesh, ascending
  std::vector<std::string> options;     // keys, where options did
  std::optional<double> without;        // its value with the earlier ingredients; none: passes
};

/// What differs between two versions and which of it matters.
struct WhyPair {
  std::string before, after;
  IngredientSet changed = 0;
  std::map<Ingredient, std::string> differences;
  double coverage = 1.0;
  std::vector<WhyFinding> findings;
  std::size_t measured = 0;             // versions and mixtures
  std::vector<std::string> unmeasured;  // mixtures that could not be, and why
};

/// Swaps ingredients between two versions, one at a time, then in pairs and so on, and measures
/// every mixture that is needed. Exact: a set is named only where the earlier version with it is
/// worse by at least half as much as the later is, and the later version without it is not; and no
/// smaller set does both. What reaches 0.8 of a limit counts with its value, so that a value at the
/// limit is booked to what made it and not to the hair that carried it over. Weights and options
/// are then taken apart: parts that are not needed are put back one by one.
///
/// With recorded failures, what they say counts as what the versions have. What this program, asked
/// of the same inputs, does not see change is made by the program that measured one of the runs.
///
/// Throws what VersionPair and failures_of() of the two versions throw.
WhyPair why(const VersionPair& pair, const WhySettings& settings, Progress& progress,
            const RecordedFailures& recorded = {});

/// The first of several versions that fails what the last fails.
struct FirstBad {
  std::size_t good = 0, bad = 0;     // numbers of neighbours: those between were not measured
  std::size_t steps = 0;             // versions measured between the first and the last
  std::vector<std::string> skipped;  // that cannot be measured, and why
};
/// By bisection, in at most ceil(log2(n)) measurements where all can be measured. `load(i)` gives a
/// version, or throws where it cannot be read. Nullopt where the last has no finding that the first
/// has not.
std::optional<FirstBad> first_bad(std::size_t count,
                                  const std::function<Failures(std::size_t)>& failures);

}  // namespace backbend::validate
