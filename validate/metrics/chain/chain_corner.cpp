#include "validate/metrics/chain/chain_corner.h"

#include <algorithm>
#include <limits>
#include <vector>

#include "validate/metrics/math/rotation.h"

namespace backbend::validate {

double chain_corner(const solver::SpinePose& pose, const solver::SpinePose& rest, int& joint) {
  using Index = std::size_t;
  joint = -1;
  const Index n = pose.position.size();
  if (n < kLeastForCorners) return std::numeric_limits<double>::quiet_NaN();
  std::vector<glm::dvec3> turn;  // beyond rest, at joints 1 .. n-2
  for (Index k = 1; k + 1 < n; ++k) {
    const auto bend = [&](const solver::SpinePose& p) {
      return arc_between(p.position[k] - p.position[k - 1], p.position[k + 1] - p.position[k]);
    };
    turn.push_back(bend(pose) - pose.turn[k - 1] * bend(rest));
  }
  double worst = 0.0;
  for (Index k = 0; k < turn.size(); ++k) {
    const glm::dvec3& below = turn[k == 0 ? 0 : k - 1];
    const glm::dvec3& above = turn[std::min(k + 1, turn.size() - 1)];
    const double corner = degrees(glm::length(0.5 * turn[k] - 0.25 * (below + above)));
    if (!(corner <= worst)) {
      worst = corner;
      joint = static_cast<int>(k + 1);
    }
  }
  return worst;
}

}  // namespace backbend::validate
