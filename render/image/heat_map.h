#pragma once
#include <glm/vec3.hpp>

namespace backbend::render {

/// Colour of `t` in 0..1 (clamped), linear Rec.709: dark blue over grey to light yellow, lightness
/// rising evenly, hues on the blue-yellow axis that every common kind of colour vision keeps.
/// NaN ("not measured") is a magenta that the scale does not hold.
glm::vec3 heat_color(float t);

}  // namespace backbend::render
