#pragma once
#include <array>

#include "render/image/lanes.h"

namespace backbend::render {

/// Blackman-Harris pixel filter, two pixels wide, as a density to draw sample positions from: every
/// sample then counts alike, tiles need no borders, and mattes use the filter of the beauty.
/// Source: M. Ernst et al., "Filter Importance Sampling", IEEE Symposium on Interactive Ray
/// Tracing, 2006.
class PixelFilter {
 public:
  PixelFilter();
  /// Offsets from the pixels' centres along one axis, in pixels within +-1, for `random` in [0, 1).
  Float8 offset(Float8 random) const {
    const Float8 at = random * static_cast<float>(kSteps);
    const Int8 step = to_int(at);
    const Float8 low = gather(inverse_.data(), step), high = gather(inverse_.data() + 1, step);
    return low + (high - low) * (at - to_float(step));
  }

 private:
  static constexpr int kSteps = 1024;
  std::array<float, kSteps + 1> inverse_;  // of the filter's cumulative distribution
};

}  // namespace backbend::render
