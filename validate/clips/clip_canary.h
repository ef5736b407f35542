#pragma once
#include "validate/clips/clip_measure.h"

namespace backbend::validate {

/// Turns one joint of the clip's longest sweep by half a turn from its middle on: found there and
/// nowhere before, or the test has measured nothing. The twin is the clip as it is.
CanaryResult clip_canary(const RigRecord& record, const skin::Clip& clip, const ClipBody& body,
                         const skin::Anatomy& anatomy);

}  // namespace backbend::validate
