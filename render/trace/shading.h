#pragma once
#include <glm/vec3.hpp>

#include "render/trace/projection.h"
#include "render/trace/surface.h"

namespace backbend::render {

/// Colours of the modes that need no light paths: each is a function of one surface point, so they
/// are free of noise at any number of samples.

/// A fixed light over the camera's left shoulder and a weak one along the view: the picture that
/// image metrics compare. Nothing but the shape goes into it.
glm::vec3 fixed_light_shade(const Projection& projection, const glm::vec3& normal);

/// A dark, glossy ball's picture looked up by the normal as the camera sees it: shows small dents.
glm::vec3 matcap_shade(const Projection& projection, const glm::vec3& normal, const glm::vec3& out);

/// Paper under contour lines: nearly white, a little darker where the surface turns away.
glm::vec3 paper_shade(const Projection& projection, const glm::vec3& normal);

/// Heat colour, shaded just enough to show the form without leaving the legend's colours.
glm::vec3 heat_shade(const Projection& projection, const glm::vec3& normal, float value, float low,
                     float high);

/// What a mode's surfaces reflect: the material's colour in beauty, the clay's in the others.
glm::vec3 albedo_at(const SceneView& scene, Mode mode, const Surface8& at, unsigned lane);

inline constexpr glm::vec3 kClayAlbedo{0.48f, 0.475f, 0.465f};

}  // namespace backbend::render
