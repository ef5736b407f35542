#pragma once
#include "validate/evidence/picture_job.h"
#include "validate/sweeps/suite.h"

namespace backbend::validate {

/// Pictures of one character under one rig that a user asks for by hand.
struct RenderRequest : PictureRequest {
  std::filesystem::path character;
  skin::AnatomyHints hints;
  DrivenChain chain = DrivenChain::spine;
  RigPlan rig;
  solver::Mapping mapping = solver::Mapping::chest;
  PoseDegrees pose;
};

/// One picture of the pose: NAME.exr and NAME.png.
RenderedFiles render_pose(const RenderRequest& request, const OutputFolder& folder,
                          Progress& progress);

/// The same picture as the bytes of a PNG; nothing is written.
std::vector<std::uint8_t> render_pose_png(const RenderRequest& request, Progress& progress);

/// Every pose of a sweep: take_sequence(). Request.pose is not asked.
RenderedFiles render_sweep(const RenderRequest& request, const Sweep& sweep,
                           const OutputFolder& folder, Progress& progress);

/// The pose from all around: take_turntable().
RenderedFiles render_turntable(const RenderRequest& request, int views, int light_views,
                               const OutputFolder& folder, Progress& progress);

/// The rig at its worst: for every sweep and metric the worst pose, and both sides of every flip.
/// Names say what is seen: NAME_extension_114.3_BB001_before.exr.
RenderedFiles render_extremes(const RenderRequest& request, const std::vector<Sweep>& sweeps,
                              const Envelope& envelope, const OutputFolder& folder,
                              Progress& progress);

/// How long a job of pictures would take here.
struct RenderEstimate {
  double minutes = 0;          // all of it; of extremes the measuring alone
  double minutes_a_frame = 0;  // of extremes, whose number measuring tells
};

/// `frames` pictures of the request, judged by part of one, in its pose and by its settings;
/// `moves`: each is of another pose. Reads the character and refuses what the job would. Writes
/// nothing.
RenderEstimate estimate_frames(const RenderRequest& request, std::size_t frames, bool moves);
/// The worst poses of the sweeps: measuring is judged by the first of them.
RenderEstimate estimate_extremes(const RenderRequest& request, const std::vector<Sweep>& sweeps,
                                 const Envelope& envelope);

}  // namespace backbend::validate
