#pragma once
#include <memory>
#include <string>

#include "validate/calibrate/draw.h"
#include "validate/metrics/surface/body_metrics.h"
#include "validate/stage/stage.h"

namespace backbend::validate {

/// A character that detectors are tried on, with all that its poses need. Not movable: its parts
/// refer to each other.
class CalibrationBody {
 public:
  CalibrationBody(skin::Character character, skin::Anatomy anatomy);
  CalibrationBody(const CalibrationBody&) = delete;
  CalibrationBody& operator=(const CalibrationBody&) = delete;

  const std::string& name() const { return character().name; }
  const Stage& stage() const { return stage_; }
  const skin::Character& character() const { return stage_.character(); }
  const skin::SpineDriver& driver() const { return stage_.driver(); }
  const BodyMetrics& metrics() const { return metrics_; }
  /// Bones of the character's own spine, hips to chest.
  int bones() const { return static_cast<int>(stage_.rest_chain().joint.size()) - 1; }

 private:
  Stage stage_;
  BodyMetrics metrics_;
};

/// A round body of 1.8 with two arms on a straight spine of this many bones, smoothly weighted: on
/// it every detector can be tried for spines that no character at hand has.
std::unique_ptr<CalibrationBody> tube_body(int bones);

/// A body pose out of a wide range: extension to 120 or flexion to 90 degrees, 45 to either side,
/// 60 of twist to either side.
solver::BodyPose random_pose(Draw& draw);

}  // namespace backbend::validate
