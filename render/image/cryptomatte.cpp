#include "render/image/cryptomatte.h"

#include <algorithm>
#include <bit>
#include <cstring>

namespace backbend::render {
namespace {

std::string hex8(std::uint32_t value) {
  constexpr char kDigit[] = "0123456789abcdef";
  std::string text(8, '0');
  for (int i = 7; i >= 0; --i, value >>= 4) text[i] = kDigit[value & 15u];
  return text;
}

std::string json_string(std::string_view text) {
  constexpr char kDigit[] = "0123456789abcdef";
  std::string out = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      out += '\\';
      out += c;
    } else if (byte < 0x20) {
      out += "\\u00";
      out += kDigit[byte >> 4];
      out += kDigit[byte & 15];
    } else {
      out += c;
    }
  }
  return out + '"';
}

}  // namespace

std::uint32_t murmur3(std::string_view text) {
  constexpr std::uint32_t kFirst = 0xcc9e2d51u, kSecond = 0x1b873593u;
  const auto mixed = [](std::uint32_t block) { return std::rotl(block * kFirst, 15) * kSecond; };
  std::uint32_t hash = 0;
  std::size_t at = 0;
  for (; at + 4 <= text.size(); at += 4) {
    std::uint32_t block;
    std::memcpy(&block, text.data() + at, 4);  // little-endian, as x86-64 is
    hash = std::rotl(hash ^ mixed(block), 13) * 5u + 0xe6546b64u;
  }
  if (at < text.size()) {
    std::uint32_t tail = 0;
    std::memcpy(&tail, text.data() + at, text.size() - at);
    hash ^= mixed(tail);
  }
  hash ^= static_cast<std::uint32_t>(text.size());
  hash = (hash ^ (hash >> 16)) * 0x85ebca6bu;
  hash = (hash ^ (hash >> 13)) * 0xc2b2ae35u;
  return hash ^ (hash >> 16);
}

std::uint32_t cryptomatte_bits(std::string_view name) {
  const std::uint32_t bits = murmur3(name);
  const std::uint32_t exponent = (bits >> 23) & 255u;
  return exponent == 0 || exponent == 255 ? bits ^ (1u << 23) : bits;
}

float cryptomatte_id(std::string_view name) { return std::bit_cast<float>(cryptomatte_bits(name)); }

std::vector<Layer> cryptomatte_layers(std::string_view name, std::size_t pixels) {
  std::vector<Layer> layers(kCryptomatteRanks / 2);
  for (std::size_t i = 0; i < layers.size(); ++i) {
    const std::string base = std::string(name) + "0" + std::to_string(i) + ".";
    // Lower case on purpose: OpenEXR's lossy codecs treat R, G, B as pictures and would break ids.
    layers[i].names = {base + "r", base + "g", base + "b", base + "a"};
    layers[i].data.assign(pixels * 4, 0.0f);
  }
  return layers;
}

void write_cryptomatte(std::span<Layer> layers, std::size_t pixel, std::span<Matte> matte) {
  std::stable_sort(matte.begin(), matte.end(),
                   [](const Matte& a, const Matte& b) { return a.coverage > b.coverage; });
  const std::size_t ranks = std::min<std::size_t>(matte.size(), kCryptomatteRanks);
  for (std::size_t rank = 0; rank < ranks; ++rank) {
    float* out = layers[rank / 2].data.data() + pixel * 4 + (rank % 2) * 2;
    out[0] = matte[rank].id;
    out[1] = matte[rank].coverage;
  }
}

std::vector<Attribute> cryptomatte_attributes(std::string_view layer,
                                              std::span<const std::string> names) {
  const std::string prefix = "cryptomatte/" + hex8(cryptomatte_bits(layer)).substr(0, 7) + "/";
  std::vector<std::string> sorted(names.begin(), names.end());
  std::sort(sorted.begin(), sorted.end());
  sorted.erase(std::unique(sorted.begin(), sorted.end()), sorted.end());
  std::string manifest = "{";
  for (const std::string& name : sorted) {
    if (manifest.size() > 1) manifest += ",";
    manifest += json_string(name) + ":\"" + hex8(cryptomatte_bits(name)) + "\"";
  }
  manifest += "}";
  return {{prefix + "name", std::string(layer)},
          {prefix + "hash", "MurmurHash3_32"},
          {prefix + "conversion", "uint32_to_float32"},
          {prefix + "manifest", manifest}};
}

}  // namespace backbend::render
