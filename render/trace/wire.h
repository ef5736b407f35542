#pragma once
#include "render/trace/projection.h"
#include "render/trace/scene_view.h"

namespace backbend::render {

/// How much of a wire lies over a film position that sees `triangle`: 1 on its edges, 0 from about
/// a pixel away. Distances are taken on the film, so lines are equally wide at every depth and
/// slant.
float wire_coverage(const SceneView& scene, const Projection& projection, std::uint32_t triangle,
                    glm::vec2 film);

}  // namespace backbend::render
