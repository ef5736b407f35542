#pragma once
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace backbend::solver {

/// The fewest edits (insert, delete, replace, swap of neighbours) that turn `a` into `b`: the
/// optimal string alignment distance.
std::size_t edit_distance(std::string_view a, std::string_view b);

/// The candidate that `word` is most likely a slip of: fewest edits (insert, delete, replace, swap
/// of neighbours), the first of equals. Empty where even that is off by more than a third of the
/// longer word, and at least two edits. What is returned lives as long as the candidates.
std::string_view nearest_name(std::string_view word, std::span<const std::string_view> candidates);
std::string_view nearest_name(std::string_view word, const std::vector<std::string>& candidates);

/// ", did you mean 'X'?", or nothing where no candidate is near.
std::string did_you_mean(std::string_view word, const std::vector<std::string>& candidates);

/// "; did you mean 'X'?" or, where nothing is near, "; known: A, B, C". Empty without candidates.
std::string suggestion(std::string_view word, std::span<const std::string_view> candidates);
std::string suggestion(std::string_view word, const std::vector<std::string>& candidates);

}  // namespace backbend::solver
