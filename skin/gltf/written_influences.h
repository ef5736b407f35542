#pragma once
#include <array>
#include <cstdint>

#include "skin/character/character.h"

namespace backbend::skin {

/// Joints and weights of one vertex as a file wants them: each joint once, sum 1 in float. A vertex
/// without weight has the joint `joint_count`, which never moves.
struct WrittenInfluences {
  std::array<std::uint16_t, kMaxInfluences> joint{};
  std::array<float, kMaxInfluences> weight{};
  int count = 0;
};

/// Throws CharacterError for a weight or joint out of range.
WrittenInfluences written_influences(const Influences& in, std::size_t joint_count,
                                     std::size_t vertex);

}  // namespace backbend::skin
