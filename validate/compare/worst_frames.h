#pragma once
#include <string>

#include "validate/camera/photographer.h"
#include "validate/files/output_folder.h"
#include "validate/measure/measure.h"
#include "validate/model/report.h"
#include "validate/sweeps/suite.h"

namespace backbend::validate {

/// One side of a comparison as it can be posed again.
struct ComparedSide {
  const Stage& stage;
  const RigRecord& rig;
  std::string character;  // the words that name it and its joints in commands
};

/// Adds to every pose that speaks against a side the commands that show it on both and, where
/// pictures are wanted, the frame of each as `compare/NAME.png`, all framed by `box`. Throws
/// WriteError, Interrupted.
void show_worst(Comparison& comparison, const ComparedSide& a, const ComparedSide& b,
                const render::Bounds& box, const PicturePlan& plan, const OutputFolder& folder,
                Progress& progress);

}  // namespace backbend::validate
