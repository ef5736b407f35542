#pragma once
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

namespace backbend::validate {

/// A linear map of colours, as nine floats and an offset: out = m * in + offset.
struct ColorMap {
  float m[3][3];
  float offset[3];

  void apply(const float in[3], float out[3]) const {
    for (int i = 0; i < 3; ++i)
      out[i] = m[i][0] * in[0] + m[i][1] * in[1] + m[i][2] * in[2] + offset[i];
  }
};

/// The colour spaces that differences are seen in; white is linear Rec.709 (1, 1, 1).
struct ColorSpaces {
  ColorMap opponent_from_rgb;  // Y = 116 Y - 16, Cx = 500 (X - Y), Cz = 200 (Y - Z), over white
  ColorMap rgb_from_opponent;
  ColorMap white_xyz_from_rgb;  // XYZ over that of white
};
const ColorSpaces& color_spaces();

/// CIELAB with a and b scaled by 0.01 L, after R. Hunt: differences of hue fade in the dark.
void hunt_lab(const float rgb[3], float lab[3]);

/// |dL| + sqrt(da^2 + db^2): follows what people say about large differences.
/// Source: S. Abasi et al., "Distance metrics for very large color differences", 2020.
float hyab(const float a[3], const float b[3]);

/// The distance to this power: compresses large differences.
inline constexpr float kColorPower = 0.7f;
/// The distance of pure green from pure blue, to the power: as far apart as colours get.
float largest_color_distance();

}  // namespace backbend::validate
