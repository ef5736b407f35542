#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "skin/anatomy/anatomy.h"

namespace backbend::skin {

/// Weights below this move nothing that a person could see, and cost as much as others.
constexpr float kTinyWeight = 0.01f;

/// An island whose weights all stay below this is not worth an artist's time.
constexpr float kBleedCounts = 0.05f;

/// Weight of one joint that stands apart from the rest of its area: painted by accident.
struct Bleed {
  int node = -1;
  std::size_t places = 0;    // in the islands that stand apart
  std::uint32_t vertex = 0;  // the one with the most of it
  float largest = 0.0f;      // its weight
};

/// How clean the weights of a character are. Counts are of vertices unless they say otherwise.
struct WeightHygiene {
  std::array<std::size_t, kMaxInfluences + 1> with_influences{};  // [n]: moved by n joints
  std::size_t unweighted = 0;
  std::size_t off_sum = 0;  // did not sum to 1 in the file
  double worst_sum = 1.0;
  std::size_t tiny = 0;  // weights, not vertices: above 0, below kTinyWeight
  std::size_t more_than_four = 0;

  // Left against right, over places that have a mirror image (within 0.2 % of the height).
  double mirrored_share = 0.0;   // of all places
  std::size_t asymmetric = 0;    // places whose weights differ from their image's by over 5 %
  double worst_asymmetry = 0.0;  // half the sum of the differences, 0..1
  std::uint32_t worst_asymmetric_vertex = 0;

  std::vector<Bleed> bleed;  // by node

  int most_influences() const;
};

/// Bleed: for each joint the places it weighs more than kTinyWeight fall into islands joined by
/// edges; on each connected shell of each part of the mesh all but the heaviest are bleed, if a
/// weight in them reaches kBleedCounts. Pieces of a costume are not: shells of their own, and
/// islands of twelve places or more that one joint holds by 90 % or more all over.
WeightHygiene judge_weights(const Character& character, const Anatomy& anatomy);

}  // namespace backbend::skin
