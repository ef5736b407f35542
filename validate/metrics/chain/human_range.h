#pragma once
#include <span>
#include <string_view>

#include "solver/rig/spine_pose.h"
#include "validate/metrics/math/rotation.h"

namespace backbend::validate {

/// Range of motion of one stretch of a human spine, degrees to one side.
struct MotionRange {
  double flexion = 0.0, extension = 0.0, lateral = 0.0, axial = 0.0;
};

/// What a human spine can do between two arc fractions (0 sacrum .. 1 first thoracic vertebra): the
/// ranges of the levels in between, each counted by how much of it lies there.
///
/// Lumbar levels: Yamamoto 1989, in vitro at 10 Nm. Thoracic: Wilke 2017, in vitro at 7.5 Nm
/// without the front of the rib cage, so generous. Levels stand at equal steps over 0..0.38 and
/// 0.38..1.
MotionRange human_range(double from, double to);

/// The joint of a chain that goes furthest beyond a human's range there.
struct RangeUse {
  double ratio = 0.0;  // of the range: above 1 no human does it
  int joint = -1;
  std::string_view direction;  // `flexion`, `extension`, `lateral`, `axial`
};

/// Compares each joint of a pose with the range of the stretch that it stands for. `fraction`: arc
/// fraction of each joint, rising. `left`: the character's left at rest, unit.
RangeUse human_range_use(const solver::SpinePose& pose, const solver::SpinePose& rest,
                         std::span<const double> fraction, const glm::dvec3& left);

}  // namespace backbend::validate
