#pragma once
#include "skin/weights/body_sides.h"
#include "skin/weights/weight_faults.h"

namespace backbend::skin {

/// Left against right: of each joint that is asked, the share of its weight that its mirror image
/// has and it lacks; of one in the middle, one side's of the other's. Where a joint has its image's
/// weight on the image's side, adds to `wrong_side` also, unless that has the joint.
void find_asymmetry(const SkinPlaces& places, const BodySides& sides, WeightAnswer& out,
                    WeightAnswer& wrong_side);

}  // namespace backbend::skin
