#pragma once
#include <string>
#include <vector>

#include "validate/metrics/surface/body_metrics.h"
#include "validate/stage/stage.h"
#include "validate/verdicts/finding.h"

namespace backbend::validate {

/// A value per vertex with the scale it is shown on.
struct VertexHeat {
  std::string label;  // what the colours show, with the unit: `mesh kink, deg`
  std::string unit;
  float low = 0.0f, high = 1.0f;
  std::vector<float> value;  // [vertices]
};

/// A pose as it was solved.
struct HeatPose {
  const solver::SpineSystem& system;
  const std::vector<double>& control;
  const PosedCharacter& posed;
  double twist = 0.0;      // radians between hips and chest, as asked
  bool stretches = false;  // whether another length is asked for
  bool baked = false;      // a frame of a clip, which cannot be posed otherwise
};

/// The values of the finding's own metric over the body: kinks, twist jumps and lost area along the
/// slices, strain, folds and inverted triangles where they are, arms by how far they have moved
/// against the chest. The scale ends at the limit or, where that is more, at the largest value.
/// Without values (`value` empty) for a metric that is of no place on the mesh, or was not
/// measured.
VertexHeat metric_heat(const Stage& stage, const BodyMetrics& body, const HeatPose& pose,
                       const Finding& finding);

}  // namespace backbend::validate
