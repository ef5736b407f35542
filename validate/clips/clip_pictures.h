#pragma once
#include "validate/clips/clip_measure.h"
#include "validate/files/output_folder.h"
#include "validate/judge/place.h"
#include "validate/stage/stage.h"
#include "validate/sweeps/suite.h"

namespace backbend::validate {

/// A measured clip and the body that it moves.
struct ClipScene {
  const Stage& stage;
  const BodyMetrics& metrics;
  const ClipBody& body;
  const RigRecord& record;
  const PlaceNames& places;
  const ClipSystem& system() const { return clip_system(record); }
};

/// Pictures of a clip, into the run's folder: of its worst findings, one of each check, the frame
/// close up from the side that shows it and the finding's own metric as colours with the place
/// marked, for a jump the frames on both sides of it; the posed mesh for any viewer and for the
/// page; and every sweep in profile for the page's scrubber (of a long one every n-th frame, shown
/// for those around it). Cameras turn with the hips' heading, so that a body that walks or turns
/// is seen from its own side. Fills the findings' pictures, the report's meshes and the sweeps'
/// frames.
///
/// Throws WriteError, Interrupted.
void make_clip_pictures(const ClipScene& scene, const PicturePlan& plan, const OutputFolder& folder,
                        Progress& progress, Report& report);

}  // namespace backbend::validate
