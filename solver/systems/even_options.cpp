#include "solver/systems/even_options.h"

#include <cmath>
#include <limits>

#include "solver/rig/limits.h"

namespace backbend::solver {
namespace {

EvenWeight read_twist(OptionReader& read) {
  constexpr int kAnatomicalSteps = 35;  // two for each mobile level, ends included
  const OptionValue* given = read.find("twist");
  if (const auto* list = given ? std::get_if<std::vector<double>>(given) : nullptr) {
    double sum = 0.0;
    for (const double v : *list) {
      if (!std::isfinite(v) || v < 0.0) {
        read.refuse("twist", "holds " + number_text(v) + ", expected densities of 0 or more");
      }
      sum += v;
    }
    if (!(sum > 0.0) || !std::isfinite(sum)) {
      read.refuse("twist", "has no density above 0 to spread the twist by");
    }
    read.keep("twist", *list);
    return EvenWeight::from_density(*list);
  }
  if (read.word("twist", {"linear", "anatomical"}) == 1) {
    return EvenWeight::from_density(human_twist_density(kAnatomicalSteps));
  }
  const double even[] = {1.0};
  return EvenWeight::from_density(even);
}

}  // namespace

EvenWeights read_even_weights(OptionReader& read) {
  // Middle's and Top's.
  const auto rows = read.spans("weights", {{0.0, 0.8}, {0.2, 1.0}}, 0.0, 1.0, 0.01);
  const EvenWeight twist = read_twist(read);
  return {EvenWeight::trapezoid(rows[0][0], rows[0][1]), twist,
          EvenWeight::trapezoid(rows[1][0], rows[1][1]), twist};
}

EvenPlaces read_even_places(OptionReader& read) {
  const int bones = read.integer("bones", 10, 1, 64);
  if (!read.find("joints")) return equal_bones(bones);
  // Held together by the rules below, not each by a range of its own.
  constexpr double kAny = std::numeric_limits<double>::max();
  const std::vector<double> joint = read.numbers("joints", {}, 0, -kAny, kAny);
  constexpr double kLeastBone = 1e-6;  // of the spine
  constexpr std::size_t kMost = 65;
  if (joint.size() < 2 || joint.size() > kMost || joint.front() != 0.0 || joint.back() != 1.0) {
    read.refuse("joints", "needs 2 to 65 arc fractions that start at 0 and end at 1");
  }
  for (std::size_t k = 1; k < joint.size(); ++k) {
    if (!(joint[k] - joint[k - 1] >= kLeastBone)) {
      read.refuse("joints", "holds " + number_text(joint[k]) + " after " +
                                number_text(joint[k - 1]) + ", expected rising arc fractions");
    }
  }
  return joints_at(joint, bones);
}

}  // namespace backbend::solver
