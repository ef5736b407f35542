#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "render/image/frame.h"

namespace backbend::render {

using Color8 = std::array<std::uint8_t, 4>;

/// An 8-bit sRGB picture with straight alpha, top row first, RGBA interleaved.
struct Picture {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgba;

  Picture() = default;
  Picture(int width, int height, Color8 fill);
  std::uint8_t* at(int x, int y) { return &rgba[(static_cast<std::size_t>(y) * width + x) * 4]; }
  const std::uint8_t* at(int x, int y) const {
    return &rgba[(static_cast<std::size_t>(y) * width + x) * 4];
  }
};

/// The sRGB curve, IEC 61966-2-1. NaN becomes 0.
float srgb_from_linear(float linear);
float linear_from_srgb(float encoded);

/// The denoised layer of a frame where it has one, else R G B, through the plain sRGB curve,
/// clamped, no tone mapping.
/// Associated alpha is divided out, so the picture looks right on any background. Throws
/// RenderError where the frame has no layer that starts with channel R.
Picture picture_from(const Frame& frame);

/// Copies `from` into `to` with its upper left corner at (x, y), blended by its alpha and clipped.
void blit(Picture& to, const Picture& from, int x, int y);

}  // namespace backbend::render
