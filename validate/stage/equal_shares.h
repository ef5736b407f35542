#pragma once
#include <optional>

#include "validate/stage/stage.h"

namespace backbend::validate {

/// The pose of a studio's own rig as the plainest rig of the same joints would make it: the turn of
/// its chest against its hips, every joint above the hips turning by the same part of it about the
/// same axis (world, as `pose.body` stands). What hangs from the spine keeps its pose against the
/// joint that it hangs from. Nullopt where the pose says nothing of the whole body, or where a
/// joint of the chain is not the skeleton's: a B-Bone's segments.
std::optional<solver::SpinePose> with_equal_shares(const Stage& stage,
                                                   const solver::SpinePose& pose);

}  // namespace backbend::validate
