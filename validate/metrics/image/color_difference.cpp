#include "validate/metrics/image/color_difference.h"

#include <cmath>
#include <glm/matrix.hpp>

namespace backbend::validate {
namespace {

/// Linear Rec.709 to XYZ, from the chromaticities of ITU-R BT.709 and D65 (0.3127, 0.3290).
glm::dmat3 xyz_from_rgb() {
  const auto xyz = [](double x, double y) { return glm::dvec3(x / y, 1.0, (1.0 - x - y) / y); };
  const glm::dmat3 primaries(xyz(0.64, 0.33), xyz(0.30, 0.60), xyz(0.15, 0.06));
  const glm::dvec3 scale = glm::inverse(primaries) * xyz(0.3127, 0.3290);
  return glm::dmat3(primaries[0] * scale.x, primaries[1] * scale.y, primaries[2] * scale.z);
}

ColorMap color_map(const glm::dmat3& m, const glm::dvec3& offset) {
  ColorMap map;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) map.m[i][j] = static_cast<float>(m[j][i]);
    map.offset[i] = static_cast<float>(offset[i]);
  }
  return map;
}

ColorSpaces make_spaces() {
  ColorSpaces spaces;

  const glm::dmat3 xyz = xyz_from_rgb();
  const glm::dvec3 white = xyz * glm::dvec3(1.0);
  const glm::dmat3 over_white(glm::dvec3(1.0 / white.x, 0, 0), glm::dvec3(0, 1.0 / white.y, 0),
                              glm::dvec3(0, 0, 1.0 / white.z));
  const glm::dmat3 opponent(glm::dvec3(0, 500, 0), glm::dvec3(116, -500, 200),
                            glm::dvec3(0, 0, -200));
  const glm::dmat3 forward = opponent * over_white * xyz;
  const glm::dvec3 offset(-16, 0, 0);
  spaces.opponent_from_rgb = color_map(forward, offset);
  spaces.rgb_from_opponent = color_map(glm::inverse(forward), -(glm::inverse(forward) * offset));
  spaces.white_xyz_from_rgb = color_map(over_white * xyz, glm::dvec3(0.0));
  return spaces;
}

}  // namespace

const ColorSpaces& color_spaces() {
  static const ColorSpaces spaces = make_spaces();
  return spaces;
}

void hunt_lab(const float rgb[3], float lab[3]) {
  float xyz[3];
  color_spaces().white_xyz_from_rgb.apply(rgb, xyz);
  for (float& v : xyz) {
    constexpr float kDelta = 6.0f / 29.0f;
    v = v > kDelta * kDelta * kDelta ? std::cbrt(v) : v / (3.0f * kDelta * kDelta) + 4.0f / 29.0f;
  }
  lab[0] = 116.0f * xyz[1] - 16.0f;
  lab[1] = 0.01f * lab[0] * 500.0f * (xyz[0] - xyz[1]);
  lab[2] = 0.01f * lab[0] * 200.0f * (xyz[1] - xyz[2]);
}

float hyab(const float a[3], const float b[3]) {
  const float da = a[1] - b[1], db = a[2] - b[2];
  return std::abs(a[0] - b[0]) + std::sqrt(da * da + db * db);
}

float largest_color_distance() {
  const float green[3] = {0, 1, 0}, blue[3] = {0, 0, 1};
  float green_lab[3], blue_lab[3];
  hunt_lab(green, green_lab);
  hunt_lab(blue, blue_lab);
  return std::pow(hyab(green_lab, blue_lab), kColorPower);
}

}  // namespace backbend::validate
