#include "validate/prove/chain_bounds.h"

#include <cmath>
#include <limits>

#include "validate/metrics/chain/chain.h"

namespace backbend::validate {
namespace {

using solver::BoxReal;
using solver::BoxVector;
using solver::Interval;

/// 2 asin of the vector part, which keeps its digits where the two hardly differ.
double most_turn(const solver::BoxTurn& from, const solver::BoxTurn& to) {
  const solver::BoxTurn between = conjugate(from) * to;
  const double sine =
      square_root(square(between.x.value) + square(between.y.value) + square(between.z.value)).hi;
  if (!std::isfinite(sine)) return std::numeric_limits<double>::infinity();
  const Interval half = arc_sine(Interval(std::min(sine, 1.0)));
  return (Interval(360.0) * half / solver::kPiInterval).hi;
}

double most_percent(const Interval& length, double of) {
  const double most = (Interval(100.0) * length / Interval(of)).hi;
  return std::isfinite(most) ? most : std::numeric_limits<double>::infinity();
}

double most_length_change(const solver::BoxPlaces& places, double rest_length) {
  BoxReal sum(0.0);
  if (places.length) {
    sum = *places.length;
  } else {
    for (std::size_t k = 1; k < places.position.size(); ++k)
      sum = sum + length(places.position[k] - places.position[k - 1]);
  }
  return most_percent(absolute(sum.value - Interval(rest_length)), rest_length);
}

}  // namespace

double most_of_chain(std::string_view check, const solver::SpineSystem& system,
                     const solver::BoxPlaces& places) {
  const solver::SpinePose& rest = system.rest();
  const double rest_length = chain_length(rest.position);
  if (check == "BB020")
    return places.arms_follow_chest ? 0.0 : most_turn(places.chest.turn, places.arms.turn);
  if (check == "BB021") {
    if (places.arms_follow_chest) return 0.0;
    const BoxVector carried =
        places.chest.posed_origin +
        places.chest.turn * BoxVector(places.arms.rest_origin - places.chest.rest_origin);
    return most_percent(length(places.arms.posed_origin - carried).value, rest_length);
  }
  if (check == "BB041") {
    const glm::dvec3 gap = rest.position.back() - rest.chest.posed_origin;
    if (places.ends_on_chest && gap == glm::dvec3(0.0)) return 0.0;
    const BoxVector now = places.position.back() - places.chest.posed_origin;
    return most_percent(length(now - places.chest.turn * BoxVector(gap)).value, rest_length);
  }
  if (check == "BB047") return most_length_change(places, rest_length);
  return std::numeric_limits<double>::infinity();
}

}  // namespace backbend::validate
