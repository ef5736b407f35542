#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "render/image/frame.h"

namespace backbend::render {

/// MurmurHash3_x86_32 with seed 0 over the bytes of `text`.
/// Source: A. Appleby, MurmurHash3, public domain; only the published algorithm is followed.
std::uint32_t murmur3(std::string_view text);

/// A name's identity in a Cryptomatte channel: its hash, with one exponent bit turned where the
/// float would be a denormal, an infinity or a NaN.
/// Source: J. Friedman and A. Jones, "Cryptomatte specification" 1.2.0, 2018.
std::uint32_t cryptomatte_bits(std::string_view name);
float cryptomatte_id(std::string_view name);

inline constexpr int kCryptomatteRanks = 6;

/// The three half-filled-with-pairs layers of one matte: `<name>00.r` .. `<name>02.a`.
std::vector<Layer> cryptomatte_layers(std::string_view name, std::size_t pixels);

/// What one pixel sees of one name.
struct Matte {
  float id;        // cryptomatte_id()
  float coverage;  // share of the pixel's filter, > 0
};

/// Writes one pixel, the largest coverage first; of equal ones the first given. Sorts `matte`;
/// entries past the sixth are dropped.
void write_cryptomatte(std::span<Layer> layers, std::size_t pixel, std::span<Matte> matte);

/// The header attributes of one matte layer with its manifest.
std::vector<Attribute> cryptomatte_attributes(std::string_view layer,
                                              std::span<const std::string> names);

}  // namespace backbend::render
