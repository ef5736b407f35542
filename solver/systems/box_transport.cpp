#include "solver/systems/box_transport.h"

#include <limits>

namespace backbend::solver {

BoxTransport::BoxTransport(const BoxTurn& turn, const glm::dvec3& direction)
    : turn_(turn), direction_(turn * BoxVector(direction)) {
  for (std::size_t j = 0; j < kBoxVariables; ++j) roll_[j] = Interval(-turn.rate[j], turn.rate[j]);
}

void BoxTransport::go(const BoxVector& direction) {
  const BoxSlopes rolled = roll_of_arc(direction_, direction);
  for (std::size_t j = 0; j < kBoxVariables; ++j) roll_[j] = roll_[j] + rolled[j];
  turn_ = shortest_arc(direction_, direction, BoxVector()) * turn_;
  direction_ = direction;
}

BoxRates BoxTransport::rates(const BoxReal& twist) const {
  BoxRates rate;
  for (std::size_t j = 0; j < kBoxVariables; ++j) {
    const Interval sum = square(roll_[j] + twist.slope[j]) + square(direction_.x.slope[j]) +
                         square(direction_.y.slope[j]) + square(direction_.z.slope[j]);
    rate[j] = sum.is_finite() ? square_root(sum).hi : std::numeric_limits<double>::infinity();
  }
  return rate;
}

}  // namespace backbend::solver
