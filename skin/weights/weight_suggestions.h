#pragma once
#include <optional>
#include <string>
#include <vector>

#include "skin/weights/weight_hygiene.h"

namespace backbend::skin {

/// One change to the weights that would make a character cleaner. Nothing here changes anything.
struct WeightSuggestion {
  std::string code;       // as the finding's: renormalise, weight_unweighted, prune_tiny, ...
  std::string change;     // what to do, one line
  std::size_t count = 0;  // of vertices that would change, or of places
  bool places = false;    // places are counted: vertices that stand together are one
  std::optional<std::uint32_t> vertex;  // where to look, if it is known: the worst, or the first
  double moves = 0.0;  // largest share of one vertex's weight that changes hands, 0..1
};

/// What hygiene calls for, in the order it should be done: sums, unweighted vertices, islands that
/// bleed, tiny weights, more than four joints, sides that differ. Empty where all is clean.
std::vector<WeightSuggestion> suggest_weights(const Character& character,
                                              const WeightHygiene& hygiene);

/// For a person, one change a line; `nothing to change` where all is clean.
std::string suggestions_text(const std::vector<WeightSuggestion>& suggestions);

/// The same as JSON, schema `backbend.suggest/1`.
std::string suggestions_json(const std::string& file,
                             const std::vector<WeightSuggestion>& suggestions);

}  // namespace backbend::skin
