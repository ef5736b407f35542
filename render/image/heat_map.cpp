#include "render/image/heat_map.h"

#include <algorithm>
#include <cmath>

namespace backbend::render {
namespace {

// Source: B. Ottosson, "A perceptual color space for image processing", 2020 (Oklab to linear RGB).
glm::vec3 linear_from_oklab(float lightness, float a, float b) {
  const float l = lightness + 0.3963377774f * a + 0.2158037573f * b;
  const float m = lightness - 0.1055613458f * a - 0.0638541728f * b;
  const float s = lightness - 0.0894841775f * a - 1.2914855480f * b;
  const float l3 = l * l * l, m3 = m * m * m, s3 = s * s * s;
  return {4.0767416621f * l3 - 3.3077115913f * m3 + 0.2309699292f * s3,
          -1.2684380046f * l3 + 2.6097574011f * m3 - 0.3413193965f * s3,
          -0.0041960863f * l3 - 0.7034186147f * m3 + 1.7076147010f * s3};
}

}  // namespace

glm::vec3 heat_color(float t) {
  if (std::isnan(t)) return {0.60f, 0.02f, 0.45f};
  t = std::clamp(t, 0.0f, 1.0f);
  const float lightness = 0.28f + 0.62f * t;
  // From blue through grey to yellow; a little red above the middle warms it and is gone at the
  // end.
  const float up = t - 0.5f;
  const float b = up < 0.0f ? 0.24f * up : 0.28f * up * (1.28f - 0.42f * t);
  const float a = up < 0.0f ? 0.03f * up : 0.10f * up * (1.0f - t);
  return glm::vec3(std::max(0.0f, linear_from_oklab(lightness, a, b).x),
                   std::max(0.0f, linear_from_oklab(lightness, a, b).y),
                   std::max(0.0f, linear_from_oklab(lightness, a, b).z));
}

}  // namespace backbend::render
