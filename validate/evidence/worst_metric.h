#pragma once
#include <string>

#include "solver/rig/spine_system.h"
#include "validate/stage/stage.h"
#include "validate/sweeps/suite.h"

namespace backbend::validate {

/// The metric of a pose that comes nearest to its default limit, or lies furthest beyond it, among
/// those that apply to the rig, the character and the pose, with its value and limit: `arm
/// drift 12.3 deg (limit 15)`. Empty where nothing could be measured.
std::string worst_metric(const Stage& stage, const solver::SpineSystem& system,
                         const PoseDegrees& pose, solver::Mapping mapping,
                         const PosedCharacter& posed);

}  // namespace backbend::validate
