#pragma once
#include "validate/clips/clip_input.h"
#include "validate/clips/clip_measure.h"
#include "validate/evidence/picture_job.h"
#include "validate/tasks/pictures_ahead.h"

namespace backbend::validate {

/// Frames of one sweep of a clip as poses that pictures are taken of. The hips are held in place,
/// as they are where the clip is judged.
///
/// File names have the file's own frames, those that a report says. Throws CharacterError where the
/// clip has no body, or several sweeps and options.animation names none of them.
class ClipPoses : public PoseSource {
 public:
  explicit ClipPoses(const ClipFiles& files);

  const Stage& stage() const override { return *input_.stage; }
  std::string rig() const override;
  std::string rig_in_full() const override { return rig(); }
  std::string inputs() const override;
  std::vector<render::Attribute> attributes() const override;
  std::size_t count() const override { return sweep().count; }
  PosedCharacter posed(std::size_t pose) const override;
  std::string text(std::size_t pose) const override;
  int frame_number(std::size_t pose) const override { return frame_numbers_[pose]; }
  std::vector<float> strain(const BodyMetrics& body, std::size_t pose,
                            const PosedCharacter& posed) const override;
  std::string worst_metric(std::size_t pose, const PosedCharacter& posed) const override;

  /// The file's own numbers of the frames, ascending.
  const std::vector<int>& frame_numbers() const { return frame_numbers_; }
  /// The pose of that frame. Throws std::invalid_argument naming those that there are.
  std::size_t pose_of_frame(int number) const;

 private:
  const skin::ClipSweep& sweep() const { return input_.clip.sweeps.front(); }

  PicturesAhead pictures_ahead_;
  ClipInput input_;
  std::vector<int> frame_numbers_;
  SweepRecord poses_;  // none of them measured
  std::unique_ptr<const ClipBody> body_;
  std::unique_ptr<const ClipSystem> system_;
};

}  // namespace backbend::validate
