#pragma once
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "render/trace/scene.h"
#include "validate/metrics/image/flip_image.h"
#include "validate/metrics/image/image.h"
#include "validate/verdicts/finding.h"

namespace backbend::validate {

/// One question asked of two pictures, and its answer.
struct PictureMeasure {
  std::string name;  // `perceptual_hdr_mean`, `normal_mean`, ...
  std::string unit;
  double value = std::numeric_limits<double>::quiet_NaN();
  /// NaN: shown only, and never decides.
  double limit = std::numeric_limits<double>::quiet_NaN();
  /// not_applicable: neither picture has what is asked about; not_measured: only one of them has,
  /// or the answer is no number.
  Verdict verdict = Verdict::not_applicable;
};

/// By how much two pictures may differ and still count as alike.
struct PictureLimits {
  /// Mean perceptual difference. A picture moved by four pixels reads 0.086, one white pixel in
  /// 64 x 64 reads 0.0011.
  double perceptual = 0.01;
  double normal_deg = 0.05;  // mean angle of the normal layers: research/reports.md 1.2
  double outline_px = 0.5;   // that 95 of 100 outline pixels keep
  double overlap = 0.995;    // of the silhouettes, at least
};

/// How two frames differ.
struct FrameDifference {
  bool identical = false;  // the same channels with the same bits
  std::vector<std::string> only_a, only_b;
  std::vector<PictureMeasure> measures;
  std::optional<NoiseTest> noise;  // where both carry the variance of their pixels
  PerceptualDifference picture;    // the HDR one, with its map; empty without colours

  /// fail where anything decided fails; else not_measured where anything could not be said, or
  /// nothing at all was; else pass.
  Verdict verdict() const;
};

/// Compares what both frames hold: colours as a display shows them (LDR) and at every exposure
/// (HDR), the angle of their normals, their silhouettes (by the matte of the whole character, else
/// by alpha). Where both carry the variance of their pixels, whether their colours differ by more
/// than noise decides in place of the perceptual difference; the outline may be off by the pixel
/// that sampling leaves open, and the overlap is only shown. Channels that differ in any other
/// layer are reported through `identical` alone.
///
/// Throws ImageError for frames of different sizes.
FrameDifference frame_difference(const render::Frame& a, const render::Frame& b,
                                 const PictureLimits& limits = {});

}  // namespace backbend::validate
