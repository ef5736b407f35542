#pragma once
#include <immintrin.h>

#include "solver/math/lanes.h"

namespace backbend::solver {

/// The largest argument that sin_cos() takes.
inline constexpr double kFastTrigonometryReach = 1e6;
/// The largest argument that sin_cos_small() takes: an eighth of a turn.
inline constexpr double kSmallAngle = 0.785398163397448;

/// Sines and cosines of four angles at once. |angle| <= kSmallAngle.
///
/// Taylor's series; the first terms left out are below 1e-16. Plain sums and products, so every
/// machine gives the same bits; exact at 0, sine odd and cosine even to the bit.
inline void sin_cos_small(Lanes x, Lanes& sine, Lanes& cosine) {
  const Lanes y = x * x;
  const Lanes s =
      Lanes(-1.0 / 6.0) +
      y * (Lanes(1.0 / 120.0) +
           y * (Lanes(-1.0 / 5040.0) +
                y * (Lanes(1.0 / 362880.0) +
                     y * (Lanes(-1.0 / 39916800.0) +
                          y * (Lanes(1.0 / 6227020800.0) + y * Lanes(-1.0 / 1307674368000.0))))));
  const Lanes c =
      Lanes(-0.5) +
      y * (Lanes(1.0 / 24.0) +
           y * (Lanes(-1.0 / 720.0) +
                y * (Lanes(1.0 / 40320.0) + y * (Lanes(-1.0 / 3628800.0) +
                                                 y * (Lanes(1.0 / 479001600.0) +
                                                      y * (Lanes(-1.0 / 87178291200.0) +
                                                           y * Lanes(1.0 / 20922789888000.0)))))));
  sine = x + x * (y * s);
  cosine = Lanes(1.0) + y * c;
}

/// The largest argument that sin_cos_tiny() takes.
inline constexpr double kTinyAngle = 0.11;

/// sin_cos_small() with half its terms, for |angle| <= kTinyAngle. Not the same bits.
inline void sin_cos_tiny(Lanes x, Lanes& sine, Lanes& cosine) {
  const Lanes y = x * x;
  const Lanes s = Lanes(-1.0 / 6.0) +
                  y * (Lanes(1.0 / 120.0) + y * (Lanes(-1.0 / 5040.0) + y * Lanes(1.0 / 362880.0)));
  const Lanes c =
      Lanes(-0.5) + y * (Lanes(1.0 / 24.0) + y * (Lanes(-1.0 / 720.0) + y * Lanes(1.0 / 40320.0)));
  sine = x + x * (y * s);
  cosine = Lanes(1.0) + y * c;
}

/// sin_cos_small() for |angle| <= kFastTrigonometryReach, within 3e-16 of the true values. For
/// small angles bit for bit sin_cos_small().
///
/// Method: Cody and Waite's reduction by multiples of pi/2, held in three parts.
inline void sin_cos(Lanes angle, Lanes& sine, Lanes& cosine) {
  const Lanes rounder(6755399441055744.0);  // 1.5 * 2^52: adding it rounds to an integer
  // pi/2 in parts of 33 bits, so that products with integers below 2^20 are exact.
  const Lanes part1(0x1.921fb544p+0), part2(0x1.0b4611a6p-34), part3(0x1.3198a2e037073p-69);
  const Lanes shifted = angle * Lanes(0.63661977236758134308) + rounder;
  const Lanes k = shifted - rounder;
  Lanes s, c;
  sin_cos_small(((angle - k * part1) - k * part2) - k * part3, s, c);
  // The integer's last two bits are the quadrant: odd ones swap, and two bits set the signs.
  const __m256i quadrant = _mm256_castpd_si256(shifted.v), two = _mm256_set1_epi64x(2);
  const __m256d odd = _mm256_castsi256_pd(_mm256_slli_epi64(quadrant, 63));
  const auto sign = [&](__m256i bits) {
    return _mm256_castsi256_pd(_mm256_slli_epi64(_mm256_and_si256(bits, two), 62));
  };
  sine = Lanes(_mm256_xor_pd(_mm256_blendv_pd(s.v, c.v, odd), sign(quadrant)));
  cosine = Lanes(_mm256_xor_pd(_mm256_blendv_pd(c.v, s.v, odd),
                               sign(_mm256_add_epi64(quadrant, _mm256_set1_epi64x(1)))));
}

/// sin_cos() of N angles in memory.
template <int N>
inline void sin_cos_block(const double* angle, double* sine, double* cosine) {
  for (int i = 0; i < N; i += Lanes::kCount) {
    double in[Lanes::kCount] = {}, s[Lanes::kCount], c[Lanes::kCount];
    const int count = N - i < Lanes::kCount ? N - i : Lanes::kCount;
    for (int k = 0; k < count; ++k) in[k] = angle[i + k];
    Lanes sines, cosines;
    sin_cos(Lanes::load(in), sines, cosines);
    sines.store(s);
    cosines.store(c);
    for (int k = 0; k < count; ++k) sine[i + k] = s[k], cosine[i + k] = c[k];
  }
}

}  // namespace backbend::solver
