#pragma once
#include <vector>

#include "validate/metrics/surface/body_metrics.h"
#include "validate/stage/stage.h"

namespace backbend::validate {

/// Where a joint of the spine stands at rest.
struct JointPlace {
  int node = -1;
  // From the middle between the torso's left and right surface at its height, in half widths there:
  // 0 in the middle, 1 on the skin. NaN where no cross-section near it has both surfaces, and on a
  // body without a pair of limbs, whose left is a guess.
  double aside = 0.0;
  // From the torso's surface, in radii of the cross-section there; 0 inside. NaN where no
  // cross-section is near it, of a joint that moves nothing, nor what hangs from it, and of a
  // human figure of bones, whose column the controls stand in front of.
  double outside = 0.0;
  // The shorter of the bones that meet there, as a share of the spine's length, where the chain
  // turns back by 120 degrees and more: this joint or the next stands past its neighbour. 0
  // elsewhere, and at the first joint above the hips, which some rigs have below them.
  double turned_back = 0.0;
};

/// Of each joint above the hips, up to the chest. `aside` and `outside` are medians of the slices
/// within a tenth of the spine, five at most.
std::vector<JointPlace> joint_places(const Stage& stage, const BodyMetrics& body);

}  // namespace backbend::validate
