#pragma once
#include <span>
#include <string_view>

#include "render/trace/cameras.h"
#include "render/trace/scene.h"
#include "solver/rig/controllers.h"
#include "validate/stage/stage.h"

namespace backbend::validate {

/// A close-up holds a ball of this radius around a finding's place, of the spine's length.
inline constexpr double kCloseUp = 0.8;

/// Settings of a frame for the page's scrubber and the review videos: they are many, so small and
/// with fewer samples than `still`.
render::Settings scrubber_frame(render::Settings still);

/// Which way a character stands, as cameras take it.
render::Facing facing_of(const skin::Anatomy& anatomy);

/// Controllers as lines in three colours that every kind of colour vision tells apart.
std::vector<render::OverlayLine> controller_lines(
    const std::vector<solver::ControllerShape>& shapes);

/// Takes pictures of one character, all framed alike. Poses are set by one thread at a time; of one
/// pose several may be shot at once. Of several poses: PhotographerPool.
class Photographer {
 public:
  /// `box` holds every pose that is to be compared.
  Photographer(const Stage& stage, const render::Bounds& box);
  /// The same with the stage's topology, which several share.
  Photographer(const Stage& stage, const render::Bounds& box,
               std::shared_ptr<const render::MeshTopology> topology);

  /// What the next pictures show. `posed` and `heat` (one value per vertex, or empty) must outlive
  /// them; `previous` (or null) is the pose before, for the motion layer; `controllers` are drawn
  /// in x-ray pictures beside the bones.
  void pose(const PosedCharacter& posed, std::span<const float> heat = {},
            const PosedCharacter* previous = nullptr,
            std::span<const render::OverlayLine> controllers = {});

  render::Frame shoot(std::string_view view, const render::Settings& settings) const;
  render::Frame shoot(const render::Camera& camera, const render::Settings& settings) const;

  const Stage& stage() const { return stage_; }
  const render::Bounds& box() const { return box_; }
  const render::Facing& facing() const { return facing_; }

 private:
  const Stage& stage_;
  render::Bounds box_;
  render::Facing facing_;
  render::Scene scene_;
  std::vector<render::OverlayLine> bones_;
};

}  // namespace backbend::validate
