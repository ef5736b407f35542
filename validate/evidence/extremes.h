#pragma once
#include <string>
#include <vector>

#include "validate/measure/measure.h"

namespace backbend::validate {

/// A pose worth a picture, and why.
struct ExtremePose {
  PoseDegrees pose;
  std::string label;    // for file names: extension_114.3_BB001_before
  std::string caption;  // for people: `flip 180 deg at extension 114.3, before`
};

/// The worst poses of a rig over the sweeps: both sides of every flip, and for every metric of
/// every sweep the pose where it is worst, where that is beyond its limit; without any such pose
/// the end of each sweep. In the order of the sweeps, no pose twice.
std::vector<ExtremePose> find_extremes(const Stage& stage, const RigPlan& plan,
                                       solver::Mapping mapping, const std::vector<Sweep>& sweeps,
                                       const Envelope& envelope, Progress& progress);

}  // namespace backbend::validate
