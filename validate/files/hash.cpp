#include "validate/files/hash.h"

#include <xxhash.h>

namespace backbend::validate {

std::string hash_text(std::uint64_t high, std::uint64_t low) {
  static constexpr char kDigits[] = "0123456789abcdef";
  std::string text(32, '0');
  for (int i = 0; i < 16; ++i) {
    text[15 - static_cast<std::size_t>(i)] = kDigits[(high >> (4 * i)) & 15];
    text[31 - static_cast<std::size_t>(i)] = kDigits[(low >> (4 * i)) & 15];
  }
  return text;
}

std::string content_hash(std::span<const std::uint8_t> bytes) {
  const XXH128_hash_t hash = XXH3_128bits(bytes.data(), bytes.size());
  return hash_text(hash.high64, hash.low64);
}

std::string content_hash(std::string_view text) {
  return content_hash(std::span(reinterpret_cast<const std::uint8_t*>(text.data()), text.size()));
}

}  // namespace backbend::validate
