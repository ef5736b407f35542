#pragma once
#include <vector>

#include "validate/camera/photographer_pool.h"
#include "validate/files/ledger.h"
#include "validate/files/output_folder.h"
#include "validate/judge/place.h"
#include "validate/measure/measure.h"
#include "validate/model/report.h"

namespace backbend::validate {

/// The box that holds every measured pose of every rig, and the rest pose: one framing for all.
render::Bounds framing_of(const Stage& stage, const std::vector<RigRecord>& records);

/// Renders what a reader of the report must see, into the run's folder: for each rig's worst
/// findings the pose under this rig close up and from the side that shows it, the same pose under
/// the other rig, and the finding's own metric as colours with its place marked; both sides of
/// every flip; the leading sweep as frames, contact sheet and video with all rigs side by
/// side, and once more for review, held at its worst angle, with a table of what each frame shows;
/// a turntable of the proposed rig at its worst; beside each finding's pictures the posed mesh as
/// pose.glb, the command that shows it again as repro.sh, and where the finding has lines for the
/// artist's program these as set_pose_PROGRAM.py. Fills the findings' pictures,
/// the report's pairs, media and meshes (their findings are the caller's to link) and the sweeps'
/// frames.
///
/// `findings` has one list for each record. Pictures that the ledger has are taken from there; a
/// shard takes its own and leaves what is put together of several pictures (sheets, videos, pairs)
/// or needs none (meshes, commands) to the merge. Throws WriteError, Interrupted.
///
/// Pictures are taken side by side; of the frames of a sweep those of all rigs are held until its
/// videos are made, of everything else what the threads work on.
void make_evidence(PhotographerPool& cameras, const BodyMetrics& body, const PlaceNames& places,
                   const PicturePlan& plan, const std::vector<RigRecord>& records,
                   std::vector<std::vector<Finding>>& findings, const OutputFolder& folder,
                   Ledger& ledger, Progress& progress, Report& report);

}  // namespace backbend::validate
