#include "validate/text/number_text.h"

#include <array>
#include <charconv>
#include <cmath>

namespace backbend::validate {
namespace {

// A fixed double needs at most 309 digits, a point and its decimals.
using Buffer = std::array<char, 400>;

std::string without_negative_zero(std::string text) {
  if (text.starts_with('-') && text.find_first_not_of("-0.") == std::string::npos) text.erase(0, 1);
  return text;
}

}  // namespace

std::string shortest(double value) {
  if (!std::isfinite(value)) return "null";
  Buffer buffer;
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value).ptr;
  return without_negative_zero({buffer.data(), end});
}

std::string fixed(double value, int digits) {
  if (!std::isfinite(value)) return "-";
  Buffer buffer;
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value,
                                 std::chars_format::fixed, digits)
                       .ptr;
  return without_negative_zero({buffer.data(), end});
}

std::string significant(double value, int digits) {
  if (!std::isfinite(value)) return "-";
  const double magnitude = std::abs(value);
  // What rounding leaves of nothing is nothing: lengths, angles and shares that people read start
  // far above.
  constexpr double kNothing = 1e-9;
  if (magnitude < kNothing) return "0";
  if (magnitude >= 1e9 || magnitude < 1e-6) {
    Buffer buffer;
    const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value,
                                   std::chars_format::scientific, digits - 1)
                         .ptr;
    return {buffer.data(), end};
  }
  const int before_point = static_cast<int>(std::floor(std::log10(magnitude))) + 1;
  std::string text = fixed(value, digits > before_point ? digits - before_point : 0);
  if (text.find('.') != std::string::npos) {
    text.erase(text.find_last_not_of('0') + 1);
    if (text.ends_with('.')) text.pop_back();
  }
  return text;
}

std::string with_sign(double value, int digits) {
  std::string text = fixed(value, digits);
  const bool is_zero = text.find_first_not_of("0.") == std::string::npos;
  if (std::isfinite(value) && !is_zero && !text.starts_with('-')) text.insert(0, 1, '+');
  return text;
}

}  // namespace backbend::validate
