#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "render/image/exr.h"
#include "render/trace/scene.h"
#include "validate/camera/photographer.h"
#include "validate/files/output_folder.h"
#include "validate/sweeps/suite.h"
#include "validate/tasks/progress.h"

namespace backbend::validate {

/// Pictures of one character under one rig that a user asks for by hand.
struct RenderRequest {
  std::filesystem::path character;
  skin::AnatomyHints hints;
  DrivenChain chain = DrivenChain::spine;
  RigPlan rig;
  solver::Mapping mapping = solver::Mapping::chest;
  PoseDegrees pose;
  std::string view = "profile";
  render::Settings settings;
  // Of a sequence, the places of the frames to make, counted from 0 and ascending. None: all, with
  // the contact sheet and the video, which are made of all.
  std::optional<std::vector<std::size_t>> frames;
  bool resume = false;               // keep existing frames that are whole and have the same inputs
  std::string name;                  // of the sequence; empty: character_rig
  std::filesystem::path export_obj;  // the posed mesh as OBJ; empty: none
  render::ExrParts parts = render::ExrParts::one;
  bool burn_in = false;  // PNG and video name rig, pose and worst metric; EXR and sheet stay clean
};

/// What a job wrote, relative to its folder.
struct RenderedFiles {
  std::vector<std::filesystem::path> frames;
  std::filesystem::path sheet, video;
  std::size_t kept = 0;  // frames that --resume found good
};

/// One picture of the pose: NAME.exr and NAME.png.
RenderedFiles render_pose(const RenderRequest& request, const OutputFolder& folder,
                          Progress& progress);

/// The same picture as the bytes of a PNG; nothing is written.
std::vector<std::uint8_t> render_pose_png(const RenderRequest& request, Progress& progress);

/// Every pose of a sweep, seen alike: NAME.1001.exr onwards, with a contact sheet and a video.
/// Request.pose is not asked.
RenderedFiles render_sweep(const RenderRequest& request, const Sweep& sweep,
                           const OutputFolder& folder, Progress& progress);

/// `views` pictures around the pose, then `light_views` from the front while the light turns around
/// it: NAME.1001.exr onwards, with a contact sheet and a video. Both turns close without repeating
/// a picture.
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
