#pragma once
#include <cstdint>
#include <limits>
#include <vector>

#include "validate/metrics/image/image.h"

namespace backbend::validate {

/// How different two pictures look to a person who blinks between them: 0 the same, 1 as different
/// as can be. (The literature calls it FLIP; here a flip is a fault of a rig, so this has its own
/// name.)
struct PerceptualDifference {
  double mean = std::numeric_limits<double>::quiet_NaN();  // the figure to judge by
  double largest = std::numeric_limits<double>::quiet_NaN();
  int x = -1, y = -1;      // of the largest
  std::vector<float> map;  // one value a pixel
  // High dynamic range only:
  std::vector<std::uint8_t> exposure;  // per pixel, the exposure that showed the difference
  double first_stop = 0.0, last_stop = 0.0;
  int exposure_count = 0;
};

/// Pixels per degree of a 0.7 m wide display of 3840 pixels seen from 0.7 m.
constexpr double kUsualPixelsPerDegree = 67.0206432765823;

/// Compares two pictures for a display: the first three channels are linear Rec.709, clamped to
/// 0..1. A value that is not finite makes mean and largest NaN. Throws ImageError for pictures of
/// different sizes.
///
/// Source: P. Andersson et al., "FLIP: A Difference Evaluator for Alternating Images", Proceedings
/// of the ACM on Computer Graphics and Interactive Techniques 3(2), 2020, with its later erratum
/// (Y over 116) and its authors' later advice to judge by the mean.
PerceptualDifference perceptual_difference(const ImageView& reference, const ImageView& test,
                                           double pixels_per_degree = kUsualPixelsPerDegree);

/// Compares two scene-linear pictures at every exposure between those that bring the reference's
/// median and its largest luminance to 0.85 after tone mapping, and keeps the worst of each pixel.
///
/// Source: P. Andersson et al., "Visualizing Errors in Rendered High Dynamic Range Images",
/// Eurographics short papers, 2021; tone mapping: the ACES fit by K. Narkowicz.
PerceptualDifference perceptual_difference_hdr(const ImageView& reference, const ImageView& test,
                                               double pixels_per_degree = kUsualPixelsPerDegree);

}  // namespace backbend::validate
