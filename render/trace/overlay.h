#pragma once
#include <span>

#include "render/trace/projection.h"
#include "render/trace/scene.h"

namespace backbend::render {

/// Draws lines over the R G B A layer of a frame, with smooth edges and regardless of depth: bones
/// and controllers must be seen inside the body. What lies behind the camera is cut off.
void draw_overlay(std::span<const OverlayLine> lines, const Projection& projection, Frame& frame);

}  // namespace backbend::render
