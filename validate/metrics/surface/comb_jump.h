#pragma once
#include "validate/metrics/surface/spine_slices.h"

namespace backbend::validate {

/// The largest jump of the curvature comb of the torso's two mid lines, belly and back.
struct CombJump {
  double angle_deg = 0.0;  // NaN where neither line is long enough
  int slice = -1;          // in the middle of it
};

/// Along each of the two material lines at right angles to `left`, chords of `window` slices
/// follow each other; the turn from chord to chord, as a rotation vector in world space, is the
/// comb's tooth. A jump is the angle of the difference of two neighbouring teeth, beyond what the
/// same teeth have at rest, degrees. An even bend has equal teeth, a crease one alone.
/// `rest` and `pose` are pose_slices() of `slices`; a line is interrupted at slices without a ring,
/// that the spine hardly moves (kSpineSlice), and where its point is not on the surface.
CombJump comb_jump(const SpineSlices& slices, const SlicePose& rest, const SlicePose& pose,
                   int window);

}  // namespace backbend::validate
