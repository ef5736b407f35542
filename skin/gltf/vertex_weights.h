#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "skin/character/character.h"

namespace backbend::skin {

/// One stored weight: joint (into Character::joints) and how much.
struct WeightEntry {
  std::uint32_t joint = 0;
  float weight = 0.0f;
};

/// What was found wrong with the weights of a mesh while they were made canonical.
struct WeightTally {
  std::size_t vertices = 0;
  std::size_t renormalised = 0;  // sums further from 1 than `slack` allows
  double worst_sum = 1.0;
  std::size_t worst_vertex = 0;
  std::size_t negative = 0;
  std::size_t cut = 0;         // more than kMaxInfluences joints
  std::size_t duplicates = 0;  // one joint named twice with weight
  double worst_cut = 0.0;      // share of a vertex's weight that was dropped
};

/// The canonical form of one vertex's weights: joints merged, largest first (ties by joint number,
/// so that split vertices of one place stay alike), cut to kMaxInfluences, summing to 1.
///
/// `slack` is how far a valid sum may be from 1. All zero: returns zeros (an unskinned vertex).
/// Negative weights count as zero. `vertex` is its number, for the tally.
Influences canonical_influences(std::span<const WeightEntry> entries, double slack,
                                std::size_t vertex, WeightTally& tally);

/// The tally in words, as import warnings. `by_rule`: in the file's format weights are shares
/// whatever their sum, so that nothing is wrong with it.
std::vector<Warning> weight_warnings(const WeightTally& tally, bool by_rule = false);

}  // namespace backbend::skin
