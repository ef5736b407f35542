#include "render/image/picture.h"

#include <algorithm>
#include <cmath>

namespace backbend::render {

Picture::Picture(int w, int h, Color8 fill) : width(w), height(h) {
  if (w < 1 || h < 1 || w > 32768 || h > 32768)
    throw RenderError("picture: size " + std::to_string(w) + " x " + std::to_string(h) +
                      " is outside 1..32768");
  rgba.resize(static_cast<std::size_t>(w) * h * 4);
  for (std::size_t i = 0; i < rgba.size(); ++i) rgba[i] = fill[i % 4];
}

float srgb_from_linear(float linear) {
  if (!(linear > 0.0f)) return 0.0f;
  if (linear >= 1.0f) return 1.0f;
  return linear <= 0.0031308f ? 12.92f * linear : 1.055f * std::pow(linear, 1.0f / 2.4f) - 0.055f;
}

float linear_from_srgb(float encoded) {
  if (!(encoded > 0.0f)) return 0.0f;
  return encoded <= 0.04045f ? encoded / 12.92f : std::pow((encoded + 0.055f) / 1.055f, 2.4f);
}

Picture picture_from(const Frame& frame) {
  const Layer* beauty = frame.find("R");
  if (!beauty || beauty->names.size() < 3) throw RenderError("picture: the frame has no R, G, B");
  const Layer* denoised = frame.find("denoised.R");
  const bool shows_denoised = denoised && denoised->names.size() == 3;
  Picture picture(frame.width, frame.height, {0, 0, 0, 255});
  const std::size_t channels = beauty->names.size();
  const std::size_t pixels = static_cast<std::size_t>(frame.width) * frame.height;
  for (std::size_t p = 0; p < pixels; ++p) {
    const float* in = beauty->data.data() + p * channels;
    std::uint8_t* out = picture.rgba.data() + p * 4;
    float alpha = channels > 3 ? in[3] : 1.0f;
    alpha = alpha > 0.0f ? std::min(alpha, 1.0f) : 0.0f;  // no number: nothing there
    const float divide = alpha > 0.0f ? 1.0f / alpha : 1.0f;
    const float* color = shows_denoised ? denoised->data.data() + p * 3 : in;
    for (int c = 0; c < 3; ++c)
      out[c] = static_cast<std::uint8_t>(srgb_from_linear(color[c] * divide) * 255.0f + 0.5f);
    out[3] = static_cast<std::uint8_t>(alpha * 255.0f + 0.5f);
  }
  return picture;
}

void blit(Picture& to, const Picture& from, int x, int y) {
  const int x0 = std::max(0, -x), x1 = std::min(from.width, to.width - x);
  const int y0 = std::max(0, -y), y1 = std::min(from.height, to.height - y);
  for (int row = y0; row < y1; ++row) {
    for (int column = x0; column < x1; ++column) {
      const std::uint8_t* in = from.at(column, row);
      std::uint8_t* out = to.at(x + column, y + row);
      const int over = in[3], under = out[3] * (255 - over) / 255;
      const int alpha = over + under;
      if (alpha == 0) continue;
      for (int c = 0; c < 3; ++c)
        out[c] = static_cast<std::uint8_t>((in[c] * over + out[c] * under + alpha / 2) / alpha);
      out[3] = static_cast<std::uint8_t>(alpha);
    }
  }
}

}  // namespace backbend::render
