#include "solver/systems/box_transport.h"

#include <limits>

namespace backbend::solver {

BoxRoll::BoxRoll(const BoxTurn& turn, const glm::dvec3& direction)
    : direction_(turn * BoxVector(direction)) {
  for (std::size_t j = 0; j < kBoxVariables; ++j) roll_[j] = Interval(-turn.rate[j], turn.rate[j]);
}

void BoxRoll::go(const BoxVector& direction) {
  go_on(direction, roll_of_arc(direction_, direction));
}

void BoxRoll::go(const BoxVector& direction, const IntervalVector& turned) {
  go_on(direction, roll_of_arc(direction_, direction, turned));
}

void BoxRoll::go_on(const BoxVector& direction, const BoxSlopes& rolled) {
  for (std::size_t j = 0; j < kBoxVariables; ++j) roll_[j] = roll_[j] + rolled[j];
  direction_ = direction;
}

BoxRates BoxRoll::rates(const BoxReal& twist) const {
  BoxRates rate;
  for (std::size_t j = 0; j < kBoxVariables; ++j) {
    const Interval sum = square(roll_[j] + twist.slope[j]) + square(direction_.x.slope[j]) +
                         square(direction_.y.slope[j]) + square(direction_.z.slope[j]);
    rate[j] = sum.is_finite() ? square_root(sum).hi : std::numeric_limits<double>::infinity();
  }
  return rate;
}

BoxTransport::BoxTransport(const BoxTurn& turn, const glm::dvec3& direction)
    : turn_(turn), direction_(turn * BoxVector(direction)) {}

void BoxTransport::go(const BoxVector& direction) {
  turn_ = shortest_arc(direction_, direction, BoxVector()) * turn_;
  direction_ = direction;
}

}  // namespace backbend::solver
