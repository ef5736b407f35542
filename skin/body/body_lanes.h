#pragma once
#include <algorithm>
#include <cstddef>
#include <vector>

#include "solver/math/lane_vectors.h"

namespace backbend::skin {

using solver::Lanes;
using solver::LaneVector;

/// The lanes of std::min, std::max and std::clamp; equal and unordered numbers likewise.
inline Lanes smaller(Lanes a, Lanes b) { return select(a > b, b, a); }
inline Lanes larger(Lanes a, Lanes b) { return select(b > a, b, a); }
inline Lanes clamped(Lanes v, Lanes low, Lanes high) {
  return select(low > v, low, select(v > high, high, v));
}
inline bool any(Lanes::Mask m) { return m.bits() != 0; }

inline LaneVector operator/(const LaneVector& v, Lanes by) {
  return {v.x / by, v.y / by, v.z / by};
}
/// glm::normalize() on each lane.
inline LaneVector normalized(const LaneVector& v) { return (1.0 / length(v)) * v; }
/// The vector of one lane.
inline glm::dvec3 lane(const LaneVector& v, int lane) { return {v.x[lane], v.y[lane], v.z[lane]}; }

/// A row of a table for each lane.
class LaneRows {
 public:
  /// The interval of `start` (ascending, two or more) in which each lane of `at` lies; the outer
  /// ones go on beyond the ends.
  LaneRows(const std::vector<double>& start, Lanes at) {
    double place[Lanes::kCount];
    at.store(place);
    for (int i = 0; i < Lanes::kCount; ++i) {
      // A place of the interval before, as most are, needs no search.
      const std::size_t guess = i > 0 ? row_[i - 1] : 0;
      if ((guess == 0 || start[guess] <= place[i]) &&
          (guess + 2 == start.size() || place[i] < start[guess + 1])) {
        row_[i] = guess;
      } else {
        row_[i] = static_cast<std::size_t>(
            std::upper_bound(start.begin() + 1, start.end() - 1, place[i]) - start.begin() - 1);
      }
    }
    one_ = row_[0] == row_[1] && row_[0] == row_[2] && row_[0] == row_[3];
  }
  std::size_t operator[](int lane) const { return row_[lane]; }
  /// `number(row)` of each lane's row.
  template <typename Number>
  Lanes pick(const Number& number) const {
    if (one_) return Lanes(number(row_[0]));
    return {number(row_[0]), number(row_[1]), number(row_[2]), number(row_[3])};
  }
  template <typename Vector>
  LaneVector pick_vector(const Vector& vector) const {
    return {pick([&](std::size_t row) { return vector(row).x; }),
            pick([&](std::size_t row) { return vector(row).y; }),
            pick([&](std::size_t row) { return vector(row).z; })};
  }

 private:
  std::size_t row_[Lanes::kCount];
  bool one_ = false;  // all the same
};

}  // namespace backbend::skin
