#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/vec2.hpp>
#include <limits>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

namespace backbend::validate {

// Every image metric sees pixels only: no joint, no pose and no finding of geometry reaches it, so
// that what it says is said independently.

/// Images that cannot be compared. what() is the whole line: what was found, what was expected.
struct ImageError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Interleaved float pixels, top row first. `data` holds width * height * channels values.
struct ImageView {
  int width = 0, height = 0, channels = 0;
  std::span<const float> data;

  std::size_t pixel_count() const { return static_cast<std::size_t>(width) * height; }
  float at(int x, int y, int channel) const {
    return data[(static_cast<std::size_t>(y) * width + x) * channels + channel];
  }
};

/// Throws ImageError unless both views are whole (sizes above 0, enough data), equally large and
/// have `channels` channels or more.
void require_alike(const ImageView& a, const ImageView& b, int channels);

/// Where a figure is: one byte a pixel, 0 or 1.
struct Mask {
  int width = 0, height = 0;
  std::vector<std::uint8_t> inside;

  std::size_t count() const;
};
/// Pixels whose channel is `threshold` or more: an alpha or a matte's coverage. NaN is outside.
Mask silhouette(const ImageView& image, int channel, float threshold = 0.5f);

/// Area in both over area in either. NaN where both are empty: nothing was compared.
double overlap(const Mask& a, const Mask& b);

/// Squared distance in pixels of each pixel centre to the nearest pixel inside; infinity
/// everywhere where none is. Exact. Source: P. Felzenszwalb, D. Huttenlocher, "Distance transforms
/// of sampled functions", Theory of Computing 8, 2012.
std::vector<double> squared_distance(const Mask& mask);

/// Distances between the outlines (pixels inside that touch an outside one) of two figures.
struct OutlineDistance {
  double largest = 0.0;  // Hausdorff distance, pixels; NaN where either figure is empty
  double most = 0.0;     // 95 of 100 outline pixels are nearer: the worse of the two directions
  int x = -1, y = -1;    // where the largest is
};
OutlineDistance outline_distance(const Mask& a, const Mask& b);

/// Centre of a matte: mean pixel position weighted by coverage; NaN where it is empty.
glm::dvec2 matte_centre(const ImageView& image, int channel);

/// Statistics over pixels. All NaN where no pixel was measured.
struct PixelStatistics {
  std::size_t count = 0;
  double mean = std::numeric_limits<double>::quiet_NaN();
  double median = std::numeric_limits<double>::quiet_NaN();
  double p95 = std::numeric_limits<double>::quiet_NaN();
  double p99 = std::numeric_limits<double>::quiet_NaN();
  double p999 = std::numeric_limits<double>::quiet_NaN();
  double largest = std::numeric_limits<double>::quiet_NaN();
  int x = -1, y = -1;  // of the largest
};

/// Angle between two normal layers (first three channels, any length), degrees, over the pixels in
/// which both show a surface. The map holds NaN elsewhere.
struct NormalDifference {
  PixelStatistics statistics;
  std::array<double, 4> share_over{};  // of pixels over 5, 11.25, 22.5 and 30 degrees
  std::vector<float> map;
};
NormalDifference normal_difference(const ImageView& a, const ImageView& b);

/// Curvature of a surface as two layers show it: per pixel the largest angle between its normal and
/// that of the pixel right of or below it, over the distance of their positions; radians per unit.
///
/// `position` and `normal` have three channels, `object` one: pixels of different numbers, or of
/// number 0 (background), are not compared. Neighbours whose depths along the view differ by more
/// than two of their footprints belong to different parts of a surface and are left out too.
/// `depth` has one channel; `pixel_angle` is the view angle of one pixel, radians.
struct SurfaceCurvature {
  PixelStatistics statistics;
  std::vector<float> map;  // NaN where nothing was compared
};
SurfaceCurvature surface_curvature(const ImageView& position, const ImageView& normal,
                                   const ImageView& object, const ImageView& depth,
                                   double pixel_angle);

/// What is left between two frames after the motion layer has been taken off: mean absolute
/// difference of `channels` colours between each pixel now and the pixel before that it came from.
///
/// `motion` holds in its first two channels how far each pixel has moved since the frame before,
/// pixels, y down. Pixels whose object number differs there, or that came from outside the frame,
/// are left out.
PixelStatistics motion_residual(const ImageView& before, const ImageView& now,
                                const ImageView& motion, const ImageView& object_before,
                                const ImageView& object_now, int channels);

/// Welch test of two noisy renders of one picture: per pixel and channel z = (a - b) /
/// sqrt(va + vb), the variances those of the pixels' means.
struct NoiseTest {
  std::size_t values = 0;
  double passed = std::numeric_limits<double>::quiet_NaN();  // share within the two-sided bound
  double bound = 0.0;                                        // |z| that a value may have
  double largest = 0.0;                                      // |z|
  bool alike = false;                                        // at least 99.75 % passed
};
/// The bound is that of a test at level `significance` over all values (Sidak). Variances are kept
/// above `least_variance`. The variance images have as many channels as the pictures.
/// Source: the z-test of renderers' test suites (research/reports.md 1.2).
NoiseTest noise_test(const ImageView& a, const ImageView& variance_a, const ImageView& b,
                     const ImageView& variance_b, double significance = 0.01,
                     double least_variance = 1e-8);

/// How far a value stands from the median of its series, in robust standard deviations (1.4826
/// times the median absolute deviation, at least `least`). One entry a value.
std::vector<double> robust_scores(std::span<const double> series, double least);

}  // namespace backbend::validate
