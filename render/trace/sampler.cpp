#include "render/trace/sampler.h"

#include <bit>

namespace backbend::render {
namespace {

// Second Sobol dimension (generator matrix: Pascal's triangle modulo 2), bits
// reversed: bit i of the index toggles row i of the reversed matrix.
constexpr std::uint32_t sobol_second_reversed(std::uint32_t index) {
  std::uint32_t value = 0;
  for (std::uint32_t column = 1u << 31; index != 0; index >>= 1, column ^= column >> 1)
    if (index & 1u) value ^= column;
  return reverse_bits(value);
}

// The same by bytes: linear, so the parts of an index are combined by XOR.
struct ByteTables {
  std::array<std::array<std::uint32_t, 256>, 4> byte;
};
const ByteTables& second_by_bytes() {
  static const ByteTables tables = [] {
    ByteTables t;
    for (int place = 0; place < 4; ++place)
      for (std::uint32_t value = 0; value < 256; ++value)
        t.byte[place][value] = sobol_second_reversed(value << (8 * place));
    return t;
  }();
  return tables;
}

// Spreads the lower 16 bits so that another number's fit between them.
Word8 every_second_bit(Word8 x) {
  x = (x | (x << 8)) & 0x00ff00ffu;
  x = (x | (x << 4)) & 0x0f0f0f0fu;
  x = (x | (x << 2)) & 0x33333333u;
  return (x | (x << 1)) & 0x55555555u;
}

}  // namespace

Sampler::Sampler(int samples, int pairs, std::uint32_t seed)
    : pairs_(pairs), sample_bits_(std::bit_width(static_cast<unsigned>(samples - 1))) {
  const std::uint32_t mixed = hash_bits(seed);
  for (std::uint32_t pair = 0; pair < static_cast<std::uint32_t>(pairs); ++pair) {
    for (std::uint32_t i = 0; i < 2; ++i) value_seed_.push_back(hash_bits(mixed + pair * 4 + i));
    order_seed_.push_back(hash_bits(mixed + pair * 4 + 2));
  }
  for (int sample = 0; sample < samples; ++sample) {
    for (std::uint32_t pair = 0; pair < static_cast<std::uint32_t>(pairs); ++pair) {
      // Another order for each pair, so that no two pairs run alike within a
      // pixel.
      const std::uint32_t order = hash_bits(mixed + pair * 4 + 3);
      const std::uint32_t shuffled =
          reverse_bits(scramble_reversed(reverse_bits(static_cast<std::uint32_t>(sample)), order));
      const std::uint32_t index = shuffled & ((1u << sample_bits_) - 1u);
      // The first Sobol dimension is the reversed index; reversed again it is
      // the index.
      point_.push_back(index);
      point_.push_back(sobol_second_reversed(index));
    }
  }
}

void Sampler::place(Int8 x, Int8 y, std::uint32_t* out) const {
  const Word8 morton = every_second_bit(Word8(x)) | (every_second_bit(Word8(y)) << 1);
  const ByteTables& second = second_by_bytes();
  const Word8 first_of_pixel = morton << static_cast<std::uint32_t>(sample_bits_);
  for (int pair = 0; pair < pairs_; ++pair) {
    const Word8 index =
        reverse_bits(scramble_reversed(reverse_bits(first_of_pixel), order_seed_[pair]));
    Word8 y_part{};
    for (int place = 0; place < 4; ++place)
      y_part ^= gather(second.byte[place].data(), Int8((index >> (8 * place)) & 255u));
    store(out + pair * 16, index);
    store(out + pair * 16 + 8, y_part);
  }
}

}  // namespace backbend::render
