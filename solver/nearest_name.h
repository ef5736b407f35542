#pragma once
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace backbend::solver {

/// The candidate that `word` is most likely a slip of: fewest edits (insert, delete, replace, swap
/// of neighbours), the first of equals. Empty where even that is off by more than a third of the
/// longer word, and at least two edits.
std::string_view nearest_name(std::string_view word, std::span<const std::string_view> candidates);

/// "; did you mean 'X'?" or, where nothing is near, "; known: A, B, C". Empty without candidates.
std::string suggestion(std::string_view word, std::span<const std::string_view> candidates);
std::string suggestion(std::string_view word, const std::vector<std::string>& candidates);

}  // namespace backbend::solver
