#pragma once
#include <immintrin.h>

#include <cstddef>

namespace backbend::skin {

/// Three coordinates of eight vertices.
struct Triple {
  __m256 x, y, z;
};

/// Eight packed x, y, z, one vertex after the other.
[[gnu::always_inline]] inline void store_in_a_row(float* out, const Triple& v) {
  const __m256 xy = _mm256_shuffle_ps(v.x, v.y, _MM_SHUFFLE(2, 0, 2, 0));    // x0 x2 y0 y2
  const __m256 yz = _mm256_shuffle_ps(v.y, v.z, _MM_SHUFFLE(3, 1, 3, 1));    // y1 y3 z1 z3
  const __m256 zx = _mm256_shuffle_ps(v.z, v.x, _MM_SHUFFLE(3, 1, 2, 0));    // z0 z2 x1 x3
  const __m256 first = _mm256_shuffle_ps(xy, zx, _MM_SHUFFLE(2, 0, 2, 0));   // x0 y0 z0 x1
  const __m256 second = _mm256_shuffle_ps(yz, xy, _MM_SHUFFLE(3, 1, 2, 0));  // y1 z1 x2 y2
  const __m256 third = _mm256_shuffle_ps(zx, yz, _MM_SHUFFLE(3, 1, 3, 1));   // z2 x3 y3 z3
  _mm_storeu_ps(out, _mm256_castps256_ps128(first));
  _mm_storeu_ps(out + 4, _mm256_castps256_ps128(second));
  _mm_storeu_ps(out + 8, _mm256_castps256_ps128(third));
  _mm_storeu_ps(out + 12, _mm256_extractf128_ps(first, 1));
  _mm_storeu_ps(out + 16, _mm256_extractf128_ps(second, 1));
  _mm_storeu_ps(out + 20, _mm256_extractf128_ps(third, 1));
}

/// Unit length; +Y where there is none. The same steps as unit_or_up(). All blocks side by side,
/// for each of the two long operations waits for the one before it.
template <std::size_t kBlocks>
[[gnu::always_inline]] inline void make_unit_or_up(Triple (&v)[kBlocks]) {
  __m256 length[kBlocks], inverse[kBlocks];
  for (std::size_t b = 0; b < kBlocks; ++b)
    length[b] = _mm256_sqrt_ps(_mm256_fmadd_ps(
        v[b].x, v[b].x, _mm256_fmadd_ps(v[b].y, v[b].y, _mm256_mul_ps(v[b].z, v[b].z))));
  for (std::size_t b = 0; b < kBlocks; ++b)
    inverse[b] = _mm256_div_ps(_mm256_set1_ps(1.0f), length[b]);
  for (std::size_t b = 0; b < kBlocks; ++b) {
    const __m256 some = _mm256_cmp_ps(length[b], _mm256_setzero_ps(), _CMP_GT_OQ);
    v[b].x = _mm256_and_ps(_mm256_mul_ps(v[b].x, inverse[b]), some);
    v[b].y = _mm256_blendv_ps(_mm256_set1_ps(1.0f), _mm256_mul_ps(v[b].y, inverse[b]), some);
    v[b].z = _mm256_and_ps(_mm256_mul_ps(v[b].z, inverse[b]), some);
  }
}

}  // namespace backbend::skin
