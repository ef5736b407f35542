#pragma once
#include <span>
#include <vector>

namespace backbend::render {

/// Two independent halves of one picture's samples, and what the camera saw without noise.
/// Every span holds width * height entries, times three where interleaved triples are named.
struct DenoiseInput {
  int width, height;
  std::span<const float> half_a, half_b;  // triples: the means of either half's samples
  std::span<const float> albedo, normal;  // triples at the pixels' centres; 0 where nothing is
  std::span<const float> depth;           // at the pixels' centres; kBackgroundDepth: nothing
  int threads = 0;                        // 0: all
};

struct Denoised {
  std::vector<float> color;  // triples
  std::vector<float> error;  // standard error of the mean over the channels
};

/// A picture with less noise, for people to look at: every pixel becomes a weighted mean of its
/// neighbours within five pixels. Weights fall with the difference of albedo, normal and depth, and
/// with that of the surrounding 3 x 3 pixels' colours as far as noise does not explain it. Each
/// half is weighted by what the other half shows, so that no noise chooses its own company, and the
/// difference of the two filtered halves estimates the error that is left.
///
/// The same bits for any number of threads. Needs finite values.
/// Source: F. Rousselle, M. Manzi and M. Zwicker, "Robust Denoising using Feature and Color
/// Information", Computer Graphics Forum 32(7), 2013, sections 3 and 4.
Denoised denoise(const DenoiseInput& in);

}  // namespace backbend::render
