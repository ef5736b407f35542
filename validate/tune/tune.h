#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "validate/model/report.h"
#include "validate/stage/stage.h"
#include "validate/sweeps/suite.h"
#include "validate/tasks/progress.h"
#include "validate/tune/headroom_gauge.h"
#include "validate/tune/option_space.h"

namespace backbend::validate {

/// Which options are tuned, on which character.
struct TuneRequest {
  RigPlan rig;
  std::filesystem::path character;
  skin::AnatomyHints hints;
  DrivenChain chain = DrivenChain::spine;
  solver::Mapping mapping = solver::Mapping::chest;
  std::string envelope;           // its name; empty: the sidecar's, else that of the kind of body
  std::vector<std::string> vary;  // OptionSpace; empty: all that change anything
  std::size_t evaluations = 200;  // rigs measured in the search
  double change = 5.0;            // % of the spine's length: as far as the chosen rig may go
  bool plan_only = false;         // measure the given rig, search nothing
  bool picture = false;
  /// Called as soon as the character is read.
  std::function<void(const CharacterFacts&)> on_character;
};

/// One rig of the trade, measured as `check` measures it, without pictures.
struct TuneChoice {
  solver::SystemSpec spec;
  std::vector<std::pair<std::string, std::string>> options;  // that differ from the given rig's
  RigGauge gauge;
  std::vector<Headroom> channels;
  Corners corners;
  std::size_t failures = 0;       // findings that fail
  std::vector<std::string> made;  // checks that fail in a sweep where the given rig's do not
};

struct TuneResult {
  CharacterFacts facts;
  std::string rig, mapping;
  Envelope envelope;
  std::vector<Direction> directions;
  std::size_t poses = 0;  // of one rig, at most
  std::vector<OptionAxis> varied;
  std::vector<std::string> idle;  // options that change nothing by themselves, and stay as given
  std::size_t evaluations = 0;    // rigs measured, those that cannot be built left out
  std::size_t impossible = 0;     // combinations of options that the system refuses
  double change = 0.0;
  double minutes = 0.0;  // of a plan: estimated
  TuneChoice given;
  std::vector<TuneChoice> choices;  // by rising change; each has more headroom than the one before
  std::optional<std::size_t> chosen;  // the one with the most headroom within `change`, without new
                                      // failures
  std::vector<std::uint8_t> sheet;    // PNG: the given rig and each choice in the same poses
};

/// Searches the options of one of our systems for more headroom at less change of shape
/// (trade_search.h, headroom_gauge.h), and measures a few choices of that trade as `check` does.
///
/// The same for any number of threads. Throws skin::CharacterError, solver::RigError (also for a
/// rig of the studio's own, whose options are not ours), Interrupted.
TuneResult tune(const TuneRequest& request, Progress& progress);

}  // namespace backbend::validate
