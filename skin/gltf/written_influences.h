#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "skin/character/character.h"

namespace backbend::skin {

/// Joints and weights of one vertex as a file wants them: each joint once, sum 1 in float. A vertex
/// without weight has the joint `joint_count`, which never moves.
struct WrittenInfluences {
  std::array<std::uint16_t, kMaxInfluences> joint{};
  std::array<float, kMaxInfluences> weight{};
  int count = 0;
};

/// Of all vertices of a character, and whether one of them has no weight at all. Throws
/// CharacterError for a weight or joint out of range.
struct WrittenSkin {
  std::vector<WrittenInfluences> influences;
  bool unskinned = false;
};
WrittenSkin written_skin(const Character& character);

}  // namespace backbend::skin
