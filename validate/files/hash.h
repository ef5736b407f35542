#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace backbend::validate {

constexpr std::size_t kHashLength = 32;

/// kHashLength hex digits of XXH3-128: names content, does not protect against forgery.
std::string content_hash(std::span<const std::uint8_t> bytes);
std::string content_hash(std::string_view text);
/// The same form for a hash that was computed elsewhere.
std::string hash_text(std::uint64_t high, std::uint64_t low);

}  // namespace backbend::validate
