#pragma once
#include <immintrin.h>

#include <cstdint>
#include <glm/vec3.hpp>

namespace backbend::validate {

/// Eight floats that go through the same arithmetic side by side. Every operation is the scalar one
/// on each lane, so a lane holds the same bits as its value alone would.
struct FloatLanes {
  static constexpr int kCount = 8;
  __m256 v;

  FloatLanes() = default;
  explicit FloatLanes(__m256 value) : v(value) {}
  FloatLanes(float all) : v(_mm256_set1_ps(all)) {}  // NOLINT: constants read better unwrapped
  static FloatLanes load(const float* p) { return FloatLanes(_mm256_loadu_ps(p)); }
  void store(float* p) const { _mm256_storeu_ps(p, v); }

  friend FloatLanes operator+(FloatLanes a, FloatLanes b) {
    return FloatLanes(_mm256_add_ps(a.v, b.v));
  }
  friend FloatLanes operator-(FloatLanes a, FloatLanes b) {
    return FloatLanes(_mm256_sub_ps(a.v, b.v));
  }
  friend FloatLanes operator*(FloatLanes a, FloatLanes b) {
    return FloatLanes(_mm256_mul_ps(a.v, b.v));
  }
  friend FloatLanes operator/(FloatLanes a, FloatLanes b) {
    return FloatLanes(_mm256_div_ps(a.v, b.v));
  }

  /// Bit i: whether it holds for lane i. NaN: as the scalar comparison.
  friend int less(FloatLanes a, FloatLanes b) {
    return _mm256_movemask_ps(_mm256_cmp_ps(a.v, b.v, _CMP_LT_OQ));
  }
  friend int at_least(FloatLanes a, FloatLanes b) {
    return _mm256_movemask_ps(_mm256_cmp_ps(a.v, b.v, _CMP_GE_OQ));
  }
};

inline FloatLanes square_root(FloatLanes a) { return FloatLanes(_mm256_sqrt_ps(a.v)); }
/// std::max(a, b) of each lane, for NaN too: `a` unless it is less than `b`.
inline FloatLanes larger(FloatLanes a, FloatLanes b) { return FloatLanes(_mm256_max_ps(b.v, a.v)); }
inline FloatLanes magnitude(FloatLanes a) {
  return FloatLanes(_mm256_andnot_ps(_mm256_set1_ps(-0.0f), a.v));
}

/// Eight vectors.
struct VectorLanes {
  FloatLanes x, y, z;

  VectorLanes() = default;
  VectorLanes(FloatLanes x, FloatLanes y, FloatLanes z) : x(x), y(y), z(z) {}
  VectorLanes(const glm::vec3& all) : x(all.x), y(all.y), z(all.z) {}  // NOLINT: as above

  friend VectorLanes operator+(const VectorLanes& a, const VectorLanes& b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
  }
  friend VectorLanes operator-(const VectorLanes& a, const VectorLanes& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
  }
  friend VectorLanes operator*(FloatLanes a, const VectorLanes& b) {
    return {a * b.x, a * b.y, a * b.z};
  }
};

/// As glm::dot and glm::cross, operation by operation.
inline FloatLanes dot(const VectorLanes& a, const VectorLanes& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline VectorLanes cross(const VectorLanes& a, const VectorLanes& b) {
  return {a.y * b.z - b.y * a.z, a.z * b.x - b.z * a.x, a.x * b.y - b.x * a.y};
}

/// The first three of the four floats at each of eight places.
template <typename At>
VectorLanes gather(At at) {
  const auto pair = [&](int i) {
    return _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_loadu_ps(at(i))),
                                _mm_loadu_ps(at(i + 4)), 1);
  };
  const __m256 a = pair(0), b = pair(1), c = pair(2), d = pair(3);
  const __m256 ab = _mm256_unpacklo_ps(a, b), cd = _mm256_unpacklo_ps(c, d);  // x x y y
  const __m256 ab_z = _mm256_unpackhi_ps(a, b), cd_z = _mm256_unpackhi_ps(c, d);
  return {FloatLanes(_mm256_shuffle_ps(ab, cd, 0x44)), FloatLanes(_mm256_shuffle_ps(ab, cd, 0xee)),
          FloatLanes(_mm256_shuffle_ps(ab_z, cd_z, 0x44))};
}

/// Writes eight vectors, each as four floats of which the last is 0.
inline void scatter(const VectorLanes& v, float* out) {
  const __m256 zero = _mm256_setzero_ps();
  const __m256 xy_low = _mm256_unpacklo_ps(v.x.v, v.y.v),
               xy_high = _mm256_unpackhi_ps(v.x.v, v.y.v);
  const __m256 z_low = _mm256_unpacklo_ps(v.z.v, zero), z_high = _mm256_unpackhi_ps(v.z.v, zero);
  const __m256 row[4] = {
      _mm256_shuffle_ps(xy_low, z_low, 0x44), _mm256_shuffle_ps(xy_low, z_low, 0xee),
      _mm256_shuffle_ps(xy_high, z_high, 0x44), _mm256_shuffle_ps(xy_high, z_high, 0xee)};
  for (int i = 0; i < 4; ++i) {
    _mm_storeu_ps(out + 4 * i, _mm256_castps256_ps128(row[i]));
    _mm_storeu_ps(out + 4 * (i + 4), _mm256_extractf128_ps(row[i], 1));
  }
}

}  // namespace backbend::validate
