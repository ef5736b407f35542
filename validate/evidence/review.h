#pragma once
#include <cstddef>
#include <string>
#include <vector>

namespace backbend::validate {

/// One frame of a review clip: a pose of the sweep, and whether the clip stands still there.
struct ReviewFrame {
  std::size_t pose = 0;
  bool held = false;
};

/// The sweep once, from its first pose to its last, standing still at `worst` for `hold` frames
/// more. Needs worst < poses.
std::vector<ReviewFrame> held_at(std::size_t poses, std::size_t worst, std::size_t hold);

/// The pose whose angle is nearest to `degrees`; of two as near the later one, where a flip is
/// past.
std::size_t nearest_pose(const std::vector<double>& control_deg, double degrees);

/// Which angle each frame of the clip shows, as CSV: frame (from 1001), seconds, degrees, held.
std::string review_csv(const std::vector<ReviewFrame>& frames,
                       const std::vector<double>& control_deg);

}  // namespace backbend::validate
