#pragma once
#include "solver/rig/spine_system.h"
#include "validate/sweeps/sweep.h"

namespace backbend::validate {

/// The rig `even` as the ideal bend, twist and stretch of a pose: with the same chest against the
/// hips, which tells what the weights allow. A tipped hip is the extension that bends the body
/// alike, seen from the hips.
struct IdealBend {
  solver::SystemSpec spec;
  PoseDegrees pose;

  explicit IdealBend(const PoseDegrees& asked) : spec{"even", {}}, pose(asked) {
    if (pose.stretch != 0.0) spec.options["stretchiness"] = 1.0;
    if (pose.hip == 0.0) return;
    const double back = pose.extension - pose.flexion + pose.hip;
    pose.extension = back > 0.0 ? back : 0.0;
    pose.flexion = back > 0.0 ? 0.0 : -back;
    pose.hip = 0.0;
  }
};

}  // namespace backbend::validate
