#pragma once
#include "render/image/picture.h"

namespace backbend::render {

/// Draws a ring around (x, y), pixels from the upper left: white between two dark lines, so that it
/// shows on any colour. `radius` in pixels; what lies outside the picture is cut off, and a centre
/// or radius that is not finite draws nothing.
void draw_mark(Picture& picture, double x, double y, double radius);

}  // namespace backbend::render
