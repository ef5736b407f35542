#pragma once
#include <vector>

#include "skin/anatomy/anatomy.h"

namespace backbend::skin {

/// How much of the torso our drivers do not move as the character's own rig would.
struct DriverCoverage {
  std::vector<int>
      helpers;  // nodes with weight on the torso that keep their place on a driven joint
  double helper_share = 0.0;     // of the torso's weight, 0..1
  std::vector<int> unreached;    // nodes with weight that nothing moves at all
  double unreached_share = 0.0;  // of the whole mesh's weight, 0..1
};

/// Twist, corrective and breast joints move in the artist's rig and stand still on their parents
/// here; what that hides must be said beside every finding.
DriverCoverage driver_coverage(const Character& character, const Anatomy& anatomy);

}  // namespace backbend::skin
