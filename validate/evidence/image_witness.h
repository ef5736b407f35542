#pragma once
#include <cmath>
#include <string>

#include "validate/evidence/image_readings.h"
#include "validate/verdicts/finding.h"

namespace backbend::validate {

/// What pictures say about a finding: visible where the reading is above `threshold`.
inline ImageWitness witness_of(const ImageReading& reading, std::string metric, double threshold) {
  ImageWitness witness;
  witness.measured = !std::isnan(reading.value);
  witness.metric = std::move(metric);
  witness.threshold = threshold;
  if (!witness.measured) return witness;
  witness.value = reading.value;
  witness.camera = reading.camera;
  witness.pixels = reading.pixels;
  witness.visible = reading.value > threshold;
  return witness;
}

}  // namespace backbend::validate
