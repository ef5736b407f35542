#include "solver/systems/even_places.h"

#include <algorithm>
#include <cassert>

namespace backbend::solver {

EvenPlaces equal_bones(int bones) {
  assert(bones >= 1);
  EvenPlaces at;
  for (int k = 0; k < bones; ++k) {
    at.joint.push_back(double(k) / bones);
    at.frame.push_back((k + 0.5) / bones);
  }
  at.joint.push_back(1.0);
  at.frame.push_back(1.0);
  return at;
}

EvenPlaces joints_at(std::span<const double> joint, int bones) {
  assert(joint.size() >= 2 && joint.front() == 0.0 && joint.back() == 1.0);
  const EvenPlaces equal = equal_bones(bones);
  EvenPlaces at{{joint.begin(), joint.end()}, {}};
  for (const double s : joint) {
    const int k = std::min(int(s * bones), bones - 1);
    const double share = s * bones - k;
    const double from = equal.frame[std::size_t(k)], to = equal.frame[std::size_t(k) + 1];
    at.frame.push_back(from + (to - from) * share);
  }
  at.frame.back() = 1.0;
  return at;
}

}  // namespace backbend::solver
