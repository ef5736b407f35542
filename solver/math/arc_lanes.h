#pragma once
#include <array>
#include <span>

#include "solver/math/lane_vectors.h"

namespace backbend::solver {

/// Arc length along a part of a piece, for one curve or for four side by side: ArcPart's numbers.
template <class Real>
struct ArcSeries {
  static constexpr int kTerms = 8;

  Real length, at_zero;
  Real odd[kTerms], even[kTerms];
  Real q[5];  // squared speed
  Real first_slope, last_slope;
};

/// Arc length of four curves with as many cubic pieces each, one to a lane: every lane has the bits
/// of Curve on its own, unless that would cut pieces finer.
class ArcLanes {
 public:
  static constexpr int kMostPieces = 4;
  using Piece = std::array<LaneVector, 4>;  // Bezier points

  /// Needs 1 to kMostPieces pieces, which stay where they are. Bit i of the result: lane i is good.
  int measure(std::span<const Piece> piece);
  Lanes length() const { return length_; }
  /// Where the curves are at arc length `s`, 0 < s < length in every good lane.
  LaneVector point_at(Lanes s) const;

 private:
  static constexpr int kMostParts = 6;

  std::span<const Piece> piece_;
  int parts_ = 0, cuts_ = 1;  // of all; of a piece
  std::array<ArcSeries<Lanes>, kMostParts> part_;
  std::array<Lanes, kMostParts> start_;
  Lanes length_;
};

}  // namespace backbend::solver
