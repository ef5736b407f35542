#pragma once
#include <immintrin.h>

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>

namespace backbend::render {

/// Eight values side by side, one for each ray of a packet. Arithmetic is that of the scalar types,
/// lane by lane, with the same rounding; a comparison gives a mask of all ones or all zeros, and
/// `mask ? a : b` chooses by lane.
using Float8 = float __attribute__((vector_size(32)));
using Int8 = std::int32_t __attribute__((vector_size(32)));
using Word8 = std::uint32_t __attribute__((vector_size(32)));

inline Float8 splat(float value) { return Float8{} + value; }
inline Int8 splat(int value) { return Int8{} + value; }
const Float8 kZero = splat(0.0f), kOne = splat(1.0f);

inline Float8 load(const float* from) { return _mm256_loadu_ps(from); }
inline void store(float* to, Float8 value) { _mm256_storeu_ps(to, value); }
inline Int8 load(const std::int32_t* from) {
  return Int8(_mm256_loadu_si256(reinterpret_cast<const __m256i*>(from)));
}
inline Word8 load(const std::uint32_t* from) {
  return Word8(_mm256_loadu_si256(reinterpret_cast<const __m256i*>(from)));
}
inline void store(std::int32_t* to, Int8 value) {
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(to), __m256i(value));
}
inline void store(std::uint32_t* to, Word8 value) {
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(to), __m256i(value));
}
inline Float8 gather(const float* base, Int8 index) {
  return _mm256_i32gather_ps(base, __m256i(index), 4);
}
inline Int8 gather(const std::int32_t* base, Int8 index) {
  return Int8(_mm256_i32gather_epi32(base, __m256i(index), 4));
}
inline Word8 gather(const std::uint32_t* base, Int8 index) {
  return Word8(_mm256_i32gather_epi32(reinterpret_cast<const int*>(base), __m256i(index), 4));
}

/// One bit a lane, lane 0 lowest.
inline unsigned bits_of(Int8 mask) {
  return static_cast<unsigned>(_mm256_movemask_ps(_mm256_castsi256_ps(__m256i(mask))));
}
/// The mask that is set in the first `count` lanes.
inline Int8 first_lanes(std::size_t count) {
  return Int8{0, 1, 2, 3, 4, 5, 6, 7} < splat(static_cast<int>(count < 8 ? count : 8));
}

inline Float8 min(Float8 a, Float8 b) { return _mm256_min_ps(a, b); }
inline Float8 max(Float8 a, Float8 b) { return _mm256_max_ps(a, b); }
inline Float8 clamp(Float8 v, float low, float high) {
  return min(max(v, splat(low)), splat(high));
}
inline Float8 sqrt(Float8 v) { return _mm256_sqrt_ps(v); }
inline Float8 abs(Float8 v) { return Float8(Int8(v) & splat(0x7fffffff)); }
/// |a| with the sign of b.
inline Float8 copysign(Float8 a, Float8 b) {
  return Float8((Int8(a) & splat(0x7fffffff)) | (Int8(b) & splat(static_cast<int>(0x80000000u))));
}
inline Float8 to_float(Int8 v) { return _mm256_cvtepi32_ps(__m256i(v)); }
inline Int8 to_int(Float8 v) { return Int8(_mm256_cvttps_epi32(v)); }

/// Eight vectors, by component.
struct Vec8 {
  Float8 x, y, z;

  glm::vec3 lane(unsigned i) const { return {x[i], y[i], z[i]}; }
  void set_lane(unsigned i, const glm::vec3& v) { x[i] = v.x, y[i] = v.y, z[i] = v.z; }
};

inline Vec8 splat(const glm::vec3& v) { return {splat(v.x), splat(v.y), splat(v.z)}; }
inline Vec8 operator+(const Vec8& a, const Vec8& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec8 operator-(const Vec8& a, const Vec8& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vec8 operator-(const Vec8& a) { return {-a.x, -a.y, -a.z}; }
inline Vec8 operator*(const Vec8& a, const Vec8& b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }
inline Vec8 operator*(const Vec8& a, Float8 s) { return {a.x * s, a.y * s, a.z * s}; }
inline Float8 dot(const Vec8& a, const Vec8& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vec8 cross(const Vec8& a, const Vec8& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline Float8 length(const Vec8& v) { return sqrt(dot(v, v)); }
inline Vec8 normalize(const Vec8& v) { return v * (splat(1.0f) / length(v)); }
inline Vec8 select(Int8 mask, const Vec8& a, const Vec8& b) {
  return {mask ? a.x : b.x, mask ? a.y : b.y, mask ? a.z : b.z};
}
inline Float8 luminance(const Vec8& c) { return 0.2126f * c.x + 0.7152f * c.y + 0.0722f * c.z; }

/// Sine and cosine of 2 pi `turns` for turns in [0, 1], to 2e-7: the angle is folded into an eighth
/// of a turn around the nearest quarter, where short Taylor series hold.
struct SineCosine8 {
  Float8 sine, cosine;
};
inline SineCosine8 sincos_turns(Float8 turns) {
  const Int8 quarter = to_int(turns * 4.0f + 0.5f);
  const Float8 x = (turns - to_float(quarter) * 0.25f) * 6.28318530717958648f;
  const Float8 x2 = x * x;
  const Float8 sine =
      x *
      (1.0f + x2 * (-1.0f / 6 + x2 * (1.0f / 120 + x2 * (-1.0f / 5040 + x2 * (1.0f / 362880)))));
  const Float8 cosine =
      1.0f + x2 * (-0.5f + x2 * (1.0f / 24 + x2 * (-1.0f / 720 + x2 * (1.0f / 40320))));
  const Int8 odd = (quarter & 1) == 1;
  const Float8 s = odd ? cosine : sine, c = odd ? sine : cosine;
  return {(quarter & 2) == 2 ? -s : s, ((quarter + 1) & 2) == 2 ? -c : c};
}

namespace lanes_detail {
/// For every mask the order that brings its lanes to the front.
constexpr auto make_compress_order() {
  std::array<std::array<std::int32_t, 8>, 256> order{};
  for (unsigned mask = 0; mask < 256; ++mask) {
    unsigned next = 0;
    for (unsigned lane = 0; lane < 8; ++lane)
      if (mask >> lane & 1u) order[mask][next++] = static_cast<std::int32_t>(lane);
  }
  return order;
}
alignas(32) inline constexpr auto kCompressOrder = make_compress_order();
}  // namespace lanes_detail

/// Moves the lanes of a mask to the front, keeping their order. Eight lanes are written each time,
/// so what they are written to needs room for seven more than are counted.
class Compress {
 public:
  explicit Compress(Int8 mask)
      : bits_(bits_of(mask)), order_(load(lanes_detail::kCompressOrder[bits_].data())) {}
  std::size_t count() const { return static_cast<std::size_t>(std::popcount(bits_)); }
  void write(float* to, Float8 value) const {
    store(to, _mm256_permutevar8x32_ps(value, __m256i(order_)));
  }
  void write(std::int32_t* to, Int8 value) const {
    store(to, Int8(_mm256_permutevar8x32_epi32(__m256i(value), __m256i(order_))));
  }

 private:
  unsigned bits_;
  Int8 order_;
};

}  // namespace backbend::render
