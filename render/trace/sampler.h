#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "render/image/lanes.h"

namespace backbend::render {

/// Mixes all bits of `x`; a word or eight of them.
/// Source: C. Wellons, "Prospecting for Hash Functions", 2018 (the
/// construction: xor-shift and multiply, twice).
template <class Word>
constexpr Word hash_bits(Word x) {
  x ^= x >> 16;
  x *= 0x7feb352du;
  x ^= x >> 15;
  x *= 0x846ca68bu;
  x ^= x >> 16;
  return x;
}

template <class Word>
constexpr Word reverse_bits(Word x) {
  x = (x >> 16) | (x << 16);
  x = ((x >> 8) & 0x00ff00ffu) | ((x & 0x00ff00ffu) << 8);
  x = ((x >> 4) & 0x0f0f0f0fu) | ((x & 0x0f0f0f0fu) << 4);
  x = ((x >> 2) & 0x33333333u) | ((x & 0x33333333u) << 2);
  return ((x >> 1) & 0x55555555u) | ((x & 0x55555555u) << 1);
}

/// A hash in which no bit depends on a higher one: an Owen scramble of
/// bit-reversed numbers. Source: B. Burley, "Practical Hash-based Owen
/// Scrambling", JCGT 9(4), 2020, section 2 (after S. Laine and T. Karras,
/// 2011).
template <class Word>
constexpr Word scramble_reversed(Word x, std::uint32_t seed) {
  x += seed;
  x ^= x * 0x6c50b47cu;
  x ^= x * 0xb82f1e52u;
  x ^= x * 0xc7afe638u;
  x ^= x * 0x8d22f6e6u;
  return x;
}

/// Eight points of the unit square.
struct Point8 {
  Float8 x, y;  // in [0, 1)
};

/// Owen-scrambled Sobol points, padded two dimensions at a time, for eight
/// pixels at once.
///
/// All pixels share one long sequence along a Morton curve, so that not only
/// the points of a pixel but also those of every aligned block of 2 x 2, 4 x 4
/// ... pixels are well spread together: the noise that is left is fine-grained,
/// and the eye averages it away. For each pair of dimensions the curve's order
/// is scrambled anew. Every prefix of 2^k points of a pixel is stratified.
///
/// Sobol's construction is linear over bits: a point is the pixel's part XOR
/// the sample's part, and both are prepared, the first once a tile, the second
/// once a frame. Source: A. Ahmed and P. Wonka, "Screen-Space Blue-Noise
/// Diffusion of Monte Carlo Sampling Error via Hierarchical Ordering of
/// Pixels", SIGGRAPH Asia 2020.
class Sampler {
 public:
  /// Prepares `samples` points of `pairs` pairs of dimensions. Needs samples,
  /// pairs > 0.
  Sampler(int samples, int pairs, std::uint32_t seed);

  /// Words that place() writes for eight pixels.
  std::size_t words_per_packet() const { return static_cast<std::size_t>(pairs_) * 16; }

  /// Writes the part of eight pixels at x, y in 0..65535.
  void place(Int8 x, Int8 y, std::uint32_t* out) const;

  /// Point `sample` of dimension pair `pair` at the eight pixels whose part is
  /// at `pixels`.
  Point8 points(int sample, int pair, const std::uint32_t* pixels) const {
    const std::uint32_t* at = pixels + pair * 16;
    const std::uint32_t* own =
        point_.data() + (static_cast<std::size_t>(sample) * pairs_ + pair) * 2;
    return scramble(load(at) ^ own[0], load(at + 8) ^ own[1], pair);
  }
  /// The same for rays that have left their packets: each its own sample, and
  /// its pixel counted in lanes over consecutive packets at `pixels`.
  Point8 points(Int8 sample, int pair, const std::uint32_t* pixels, Int8 pixel) const {
    const Int8 at = (pixel >> 3) * (pairs_ * 16) + (pixel & 7) + pair * 16;
    const Int8 own = (sample * pairs_ + pair) * 2;
    return scramble(gather(pixels, at) ^ gather(point_.data(), own),
                    gather(pixels + 8, at) ^ gather(point_.data() + 1, own), pair);
  }

 private:
  Point8 scramble(Word8 x, Word8 y, int pair) const {
    const std::uint32_t* seed = value_seed_.data() + pair * 2;
    return {to_unit(reverse_bits(scramble_reversed(x, seed[0]))),
            to_unit(reverse_bits(scramble_reversed(y, seed[1])))};
  }
  // The upper 24 bits: as many as a float holds, so that 1 is never reached.
  static Float8 to_unit(Word8 bits) { return to_float(Int8(bits >> 8)) * 0x1p-24f; }

  int pairs_;
  int sample_bits_;                   // 2^sample_bits_ >= samples: a pixel's share of the curve
  std::vector<std::uint32_t> point_;  // [sample][pair]: x, y; binary fractions, bits reversed
  std::vector<std::uint32_t> value_seed_;  // [pair]: of x, of y
  std::vector<std::uint32_t> order_seed_;  // [pair]
};

}  // namespace backbend::render
