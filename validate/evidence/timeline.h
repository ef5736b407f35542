#pragma once
#include <string>

#include "validate/model/report.h"

namespace backbend::validate {

// OpenTimelineIO timelines of a report, for players such as RV and xSTUDIO: JSON in the folder
// `review/` of a run, media named relative to that folder, 24 frames a second. Schemas: Timeline.1,
// Stack.1, Track.1, Clip.1, Gap.1, Marker.2, ImageSequenceReference.1, ExternalReference.1. The
// same report gives the same bytes. Names are UTF-8 whatever the report holds.

/// The pictured sweeps: a track for each rig, the last (topmost) one the first of the report; in
/// each, one clip after the other for each character and mapping, lined up over all tracks. Each
/// finding on a pictured sweep is a marker of one frame on its clip, at the frame whose angle is
/// nearest; clips count frames from kFirstFrame, as the pictures are named. Empty where no sweep
/// has pictures.
std::string sweeps_otio(const Report& report);

/// The pictured findings, worst first, two seconds each: tracks, from the top, of the pose under
/// this rig, of what it is compared with (the other side of a flip, the other rig), and of the
/// heat. A marker on each clip of the top track says what was found. Empty where no finding has a
/// picture.
std::string findings_otio(const Report& report);

}  // namespace backbend::validate
