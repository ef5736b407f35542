#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "render/image/exr.h"
#include "render/trace/scene.h"
#include "validate/camera/photographer.h"
#include "validate/files/output_folder.h"
#include "validate/metrics/surface/body_metrics.h"
#include "validate/tasks/progress.h"

namespace backbend::validate {

/// How pictures that a user asks for by hand are made, whatever poses the body.
struct PictureRequest {
  std::string view = "profile";
  render::Settings settings;
  // Of a sequence, the places of the frames to make, counted from 0 and ascending. None: all, with
  // the contact sheet and the video, which are made of all.
  std::optional<std::vector<std::size_t>> frames;
  bool resume = false;               // keep existing frames that are whole and have the same inputs
  std::string name;                  // of the files; empty: the source's
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

/// The poses of one body that pictures are taken of, counted from 0.
class PoseSource {
 public:
  PoseSource() = default;
  virtual ~PoseSource() = default;
  PoseSource(const PoseSource&) = delete;
  PoseSource& operator=(const PoseSource&) = delete;

  virtual const Stage& stage() const = 0;
  /// What moves the body, for file names and titles.
  virtual std::string rig() const = 0;
  /// The same for a text that is drawn into the picture.
  virtual std::string rig_in_full() const = 0;
  /// All that a picture depends on beside pose, camera and settings.
  virtual std::string inputs() const = 0;
  /// Where a picture is from, for its file.
  virtual std::vector<render::Attribute> attributes() const = 0;

  virtual std::size_t count() const = 0;
  virtual PosedCharacter posed(std::size_t pose) const = 0;
  /// A pose for a person.
  virtual std::string text(std::size_t pose) const = 0;
  /// In the file names of a sequence.
  virtual int frame_number(std::size_t pose) const;
  /// Whether poses may only be asked one after another.
  virtual bool is_asked_in_order() const { return false; }
  /// Strain over the ideal bend's, one value per vertex.
  virtual std::vector<float> strain(const BodyMetrics& body, std::size_t pose,
                                    const PosedCharacter& posed) const = 0;
  /// What x-ray pictures show beside the bones.
  virtual std::vector<render::OverlayLine> controllers(std::size_t /*pose*/) const { return {}; }
  /// See worst_metric.h.
  virtual std::string worst_metric(std::size_t pose, const PosedCharacter& posed) const = 0;
};

/// The body and what moves it; once where both have one name, as a body with motion of its own.
std::string title_of(const PoseSource& source, const char* between = "  ");

/// One picture of a pose: NAME.exr and NAME.png.
RenderedFiles take_still(const PoseSource& source, std::size_t pose, const PictureRequest& request,
                         const OutputFolder& folder, Progress& progress);

/// The same picture as the bytes of a PNG; nothing is written.
std::vector<std::uint8_t> take_still_png(const PoseSource& source, std::size_t pose,
                                         const PictureRequest& request, Progress& progress);

/// Every pose, seen alike: NAME.1001.exr onwards, with a contact sheet called `title` and a video.
RenderedFiles take_sequence(const PoseSource& source, const std::string& title,
                            const PictureRequest& request, const OutputFolder& folder,
                            Progress& progress);

/// `views` pictures around the pose, then `light_views` from the front while the light turns around
/// it: NAME.1001.exr onwards, with a contact sheet and a video. Both turns close without repeating
/// a picture.
RenderedFiles take_turntable(const PoseSource& source, std::size_t pose, int views, int light_views,
                             const PictureRequest& request, const OutputFolder& folder,
                             Progress& progress);

/// Every pose as a picture of its own, all framed alike: NAME_LABEL.exr for each of `labels`, with
/// a contact sheet called NAME_KIND.png of `captions`.
RenderedFiles take_labelled(const PoseSource& source, const std::string& kind,
                            const std::vector<std::string>& labels,
                            const std::vector<std::string>& captions, const PictureRequest& request,
                            const OutputFolder& folder, Progress& progress);

/// Minutes for one such picture here, judged by part of one; `moves`: with what a pose of its own
/// costs. Writes nothing.
double minutes_a_picture(const PoseSource& source, std::size_t pose, const PictureRequest& request,
                         bool moves);

}  // namespace backbend::validate
