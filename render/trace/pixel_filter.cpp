#include "render/trace/pixel_filter.h"

#include <cmath>
#include <numbers>

namespace backbend::render {
namespace {

// Integral of the window from -1 to x, not normalised.
double cumulative(double x) {
  constexpr double kA[4] = {0.35875, 0.48829, 0.14128, 0.01168};  // F. Harris, 1978
  const double pi = std::numbers::pi;
  double sum = kA[0] * (x + 1.0);
  for (int k = 1; k < 4; ++k) sum += kA[k] * std::sin(k * pi * x) / (k * pi);
  return sum;
}

}  // namespace

PixelFilter::PixelFilter() {
  const double total = cumulative(1.0);
  for (int i = 0; i <= kSteps; ++i) {
    double low = -1.0, high = 1.0;
    for (int halving = 0; halving < 50; ++halving) {
      const double middle = 0.5 * (low + high);
      (cumulative(middle) < total * i / kSteps ? low : high) = middle;
    }
    inverse_[i] = static_cast<float>(0.5 * (low + high));
  }
}

}  // namespace backbend::render
