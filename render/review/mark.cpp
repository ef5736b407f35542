#include "render/review/mark.h"

#include <algorithm>
#include <cmath>

namespace backbend::render {

void draw_mark(Picture& picture, double x, double y, double radius) {
  if (!std::isfinite(x) || !std::isfinite(y) || !std::isfinite(radius) || radius <= 0.0) return;
  const double line = std::max(1.0, radius / 8.0);  // width of the white ring; the dark ones' too
  const double reach = radius + 1.5 * line + 1.0;
  const auto first = [&](double at) {
    return std::max(0, static_cast<int>(std::floor(at - reach)));
  };
  const auto last = [&](double at, int size) {
    return std::min(size - 1, static_cast<int>(std::ceil(std::min(at + reach, 1.0 * size))));
  };
  if (x + reach < 0.0 || y + reach < 0.0 || x - reach > picture.width || y - reach > picture.height)
    return;
  for (int row = first(y); row <= last(y, picture.height); ++row) {
    for (int column = first(x); column <= last(x, picture.width); ++column) {
      const double off =
          std::abs(std::hypot(column + 0.5 - x, row + 0.5 - y) - radius);  // from the ring's middle
      // Edges are one pixel wide.
      const double inside = std::clamp(1.5 * line + 0.5 - off, 0.0, 1.0);
      const double white = std::clamp(0.5 * line + 0.5 - off, 0.0, 1.0);
      if (inside == 0.0) continue;
      std::uint8_t* pixel = picture.at(column, row);
      for (int channel = 0; channel < 4; ++channel) {
        const double ink = channel == 3 ? 255.0 : 20.0 + 235.0 * white;
        pixel[channel] = static_cast<std::uint8_t>(
            std::lround(pixel[channel] + inside * (ink - pixel[channel])));
      }
    }
  }
}

}  // namespace backbend::render
