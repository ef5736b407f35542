#pragma once
#include <string>
#include <vector>

#include "skin/anatomy/anatomy.h"
#include "skin/anatomy/skeleton_shape.h"

namespace backbend::skin {

/// The joints with weight that hang from no driven joint, each with the joint it goes with.
///
/// `driven` tells for every node whether the spine, a limb or the tail carries it, `aside` whether
/// it is of another figure, which nothing carries. A loose joint goes with the driven joint it
/// touches (within 3 % of the size), else with the one that moves the most of the same places:
/// limbs of rigs whose joints hang beside the spine from a mechanism's root. Of a second copy of
/// the skeleton, as exporters write one for each mesh, each joint goes with the one of its name and
/// place. Ancestors of the body are not loose. A reason is added to `reasons` for each; leaders
/// stand before those that follow their followers.
std::vector<Follower> find_loose_joints(const Character& character, const SkeletonShape& shape,
                                        const std::vector<bool>& driven,
                                        const std::vector<bool>& aside, int hip,
                                        std::vector<std::string>& reasons);

}  // namespace backbend::skin
