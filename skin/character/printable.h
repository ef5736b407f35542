#pragma once
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace backbend::skin {

/// `text` in single quotes, fit for one line of a terminal: control characters, and bytes that are
/// not UTF-8, become `?`; anything past 80 bytes becomes `...`. Names in a file are hostile.
std::string in_quotes(std::string_view text);

/// The same without the quotes.
std::string printable(std::string_view text);

/// `'a', 'b', 'c'`, and how many more there are past eight; `none` for an empty list.
std::string list_in_quotes(const std::vector<std::string>& texts);

/// `value` in the shortest form with at most `digits` significant digits, whatever the locale.
std::string number_text(double value, int digits = 4);

/// 13380 as `13 380`.
std::string count_text(std::size_t count);

/// `1 place`, `13 380 places`; `many` where more than one is not `one` and an s.
std::string plural(std::size_t count, const std::string& one, const std::string& many = "");

}  // namespace backbend::skin
