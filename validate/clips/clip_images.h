#pragma once
#include "validate/clips/clip_pictures.h"

namespace backbend::validate {

/// What small pictures say about a finding of a clip, by themselves: of a jump, how far the change
/// of the picture's motion at that step stands out from the steps around it; of a kink or a thin
/// slice, how the torso differs from an even bend with the same ends and weights. Not measured,
/// with a note, where no picture metric looks at the check. `finding.at.pose` is a frame of
/// `sweep`.
ImageWitness clip_witness(const ClipScene& scene, const SweepRecord& sweep, const Finding& finding);

}  // namespace backbend::validate
