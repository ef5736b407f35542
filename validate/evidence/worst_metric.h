#pragma once
#include <functional>
#include <string>

#include "solver/rig/spine_system.h"
#include "validate/measure/measure.h"
#include "validate/stage/stage.h"
#include "validate/sweeps/suite.h"
#include "validate/verdicts/limits.h"

namespace backbend::validate {

/// The metric of a pose that comes nearest to its default limit, or lies furthest beyond it, among
/// those that apply to the rig, the character and the pose, with its value and limit: `arm
/// drift 12.3 deg (limit 15)`. Empty where nothing could be measured.
std::string worst_metric(const Stage& stage, const solver::SpineSystem& system,
                         const PoseDegrees& pose, solver::Mapping mapping,
                         const PosedCharacter& posed);

/// The same of a pose that was measured; `applies`: whether a metric means anything at it.
std::string worst_of(const PoseRecord& record, const LimitSet& limits,
                     const std::function<bool(const Metric&)>& applies);

}  // namespace backbend::validate
