#pragma once
#include "validate/stage/stage.h"

namespace backbend::validate {

/// A pose in which a motion carries both arms, clavicle to hand, torn off the ribs if need be: what
/// a rig's own arm parent does with them, for pictures of arm drift. Everything else stands as
/// Stage::pose() has it.
PosedCharacter pose_with_arms(const Stage& stage, const solver::SpineSystem& system,
                              const solver::SpinePose& spine, const solver::RigidMotion& arms);

}  // namespace backbend::validate
