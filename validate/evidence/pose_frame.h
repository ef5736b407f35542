#pragma once
#include <span>
#include <string>

#include "validate/camera/photographer.h"

namespace backbend::validate {

/// The top of the strain scale in heat pictures: the limit of BB032.
inline constexpr float kStrainHeatTop = 20.0f;

/// What one picture of one pose holds: the character at rest and in the pose, world space.
render::Bounds framing_box(const Stage& stage, const PosedCharacter& posed);

/// One picture of a posed character, framed as `backbend render` frames it: by its rest and this
/// pose, from a view that render::view_names() lists.
///
/// `heat`: one value per vertex, for the heat mode; or empty. `controllers`: drawn in x-ray
/// pictures. Throws render::RenderError for an unknown view or a mesh that is not finite;
/// Interrupted.
render::Frame pose_frame(const Stage& stage, const PosedCharacter& posed, const std::string& view,
                         const render::Settings& settings, std::span<const float> heat = {},
                         std::span<const render::OverlayLine> controllers = {});

}  // namespace backbend::validate
