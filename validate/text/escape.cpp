#include "validate/text/escape.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>

namespace backbend::validate {
namespace {

struct Range {
  char32_t first, last;
};

struct Decoded {
  char32_t code = 0;
  std::size_t size = 1;
  bool valid = false;
};

/// The character at the start of `text`: shortest form only, no surrogates, at most U+10FFFF.
Decoded decode(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char lead = byte(0);
  if (lead < 0x80) return {lead, 1, true};
  const std::size_t size = lead >= 0xf0 ? 4 : lead >= 0xe0 ? 3 : 2;
  if (lead < 0xc2 || lead > 0xf4 || text.size() < size) return {};
  char32_t code = lead & (0xffu >> (size + 1));
  for (std::size_t i = 1; i < size; ++i) {
    if ((byte(i) & 0xc0) != 0x80) return {};
    code = code << 6 | (byte(i) & 0x3fu);
  }
  constexpr std::array<char32_t, 5> kSmallest{0, 0, 0x80, 0x800, 0x10000};
  const bool surrogate = code >= 0xd800 && code <= 0xdfff;
  if (code < kSmallest[size] || surrogate || code > 0x10ffff) return {};
  return {code, size, true};
}

bool within(std::span<const Range> ranges, char32_t code) {
  const auto* const after =
      std::upper_bound(ranges.data(), ranges.data() + ranges.size(), code,
                       [](char32_t value, const Range& range) { return value < range.first; });
  return after != ranges.data() && code <= (after - 1)->last;
}

// Controls, then what Unicode calls format characters or default-ignorable: they reorder or hide
// text. Private use and non-characters have no agreed look.
constexpr std::array<Range, 22> kActing{
    {{0x0, 0x1f},        {0x7f, 0x9f},       {0xad, 0xad},     {0x34f, 0x34f},   {0x61c, 0x61c},
     {0x115f, 0x1160},   {0x17b4, 0x17b5},   {0x180b, 0x180f}, {0x200b, 0x200f}, {0x2028, 0x202e},
     {0x2060, 0x206f},   {0x3164, 0x3164},   {0xe000, 0xf8ff}, {0xfdd0, 0xfdef}, {0xfe00, 0xfe0f},
     {0xfeff, 0xfeff},   {0xffa0, 0xffa0},   {0xfff0, 0xfffb}, {0xfffe, 0xffff}, {0x1bca0, 0x1bca3},
     {0x1d173, 0x1d17a}, {0xe0000, 0x10ffff}}};

constexpr std::array<Range, 12> kCombining{{{0x300, 0x36f},
                                            {0x483, 0x489},
                                            {0x591, 0x5bd},
                                            {0x610, 0x61a},
                                            {0x64b, 0x65f},
                                            {0x93c, 0x93c},
                                            {0x941, 0x948},
                                            {0xe31, 0xe3a},
                                            {0x1ab0, 0x1aff},
                                            {0x1dc0, 0x1dff},
                                            {0x20d0, 0x20ff},
                                            {0xfe20, 0xfe2f}}};

constexpr std::array<Range, 8> kWide{{{0x1100, 0x115f},
                                      {0x2e80, 0x303e},
                                      {0x3041, 0xa4cf},
                                      {0xac00, 0xd7a3},
                                      {0xf900, 0xfaff},
                                      {0xfe30, 0xfe6f},
                                      {0xff00, 0xff60},
                                      {0x1f300, 0x1faff}}};

std::string hex(std::uint32_t value, int digits) {
  std::string text(static_cast<std::size_t>(digits), '0');
  for (auto digit = text.rbegin(); digit != text.rend(); ++digit, value >>= 4)
    *digit = "0123456789abcdef"[value & 15u];
  return text;
}

std::string spelled_out(char32_t code) {
  if (code == U'\n') return "\\n";
  if (code == U'\t') return "\\t";
  if (code == U'\r') return "\\r";
  if (code < 0x80) return "\\x" + hex(code, 2);
  return code < 0x10000 ? "\\u" + hex(code, 4) : "\\U" + hex(code, 8);
}

std::size_t width_of(char32_t code) {
  if (within(kCombining, code)) return 0;
  return within(kWide, code) || (code >= 0x20000 && code <= 0x3fffd) ? 2 : 1;
}

}  // namespace

std::string visible(std::string_view text) {
  std::string out;
  while (!text.empty()) {
    const Decoded next = decode(text);
    if (!next.valid)
      out += "\\x" + hex(static_cast<unsigned char>(text[0]), 2);
    else if (within(kActing, next.code))
      out += spelled_out(next.code);
    else
      out += text.substr(0, next.size);
    text.remove_prefix(next.size);
  }
  return out;
}

std::string valid_utf8(std::string_view text) {
  std::string out;
  while (!text.empty()) {
    const Decoded next = decode(text);
    out += next.valid ? text.substr(0, next.size) : std::string_view("\xef\xbf\xbd");
    text.remove_prefix(next.size);
  }
  return out;
}

std::string markup_text(std::string_view text) {
  std::string out;
  for (const char c : visible(text)) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\'':
        out += "&#39;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string markdown_code(std::string_view text) {
  std::string shown = visible(text);
  if (shown.find_first_not_of(' ') == std::string::npos) return "-";
  // A table cell is cut at every bar before code spans are read, and the escape for it is read
  // differently inside and outside tables: a look-alike has one meaning everywhere.
  for (std::size_t bar = shown.find('|'); bar != std::string::npos; bar = shown.find('|', bar))
    shown.replace(bar, 1, "\xc2\xa6");
  std::size_t longest = 0, run = 0;
  for (const char c : shown) {
    run = c == '`' ? run + 1 : 0;
    longest = std::max(longest, run);
  }
  const std::string fence(longest + 1, '`');
  // One blank on each side is stripped by the reader; without it a leading backtick joins the
  // fence.
  const std::string_view blank = longest > 0 ? " " : "";
  return fence + std::string(blank) + shown + std::string(blank) + fence;
}

std::string csv_text(std::string_view text) {
  std::string cell = visible(text);
  const std::size_t first = cell.find_first_not_of(' ');
  if (first != std::string::npos) {
    const std::string_view rest = std::string_view(cell).substr(first);
    // Spreadsheets also read the full-width forms of these as the start of a formula, and a text
    // that began with a control character may lose it on import.
    constexpr std::array<std::string_view, 9> kStarts{
        "=", "+", "-", "@", "\\", "\xef\xbc\x9d", "\xef\xbc\x8b", "\xef\xbc\x8d", "\xef\xbc\xa0"};
    const bool formula = std::any_of(kStarts.begin(), kStarts.end(), [&](std::string_view start) {
      return rest.starts_with(start);
    });
    if (formula) cell.insert(0, 1, '\'');
  }
  if (cell.find_first_of(",\";'") == std::string::npos && first == 0) return cell;
  std::string quoted = "\"";
  for (const char c : cell) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + '"';
}

std::string json_text(std::string_view text) {
  std::string out = "\"";
  for (const char c : valid_utf8(text)) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\')
      out += {'\\', c};
    else if (c == '\n')
      out += "\\n";
    else if (byte < 0x20 || byte == 0x7f)
      out += "\\u" + hex(byte, 4);
    else
      out += c;
  }
  return out + '"';
}

std::string json_for_script(std::string_view json) {
  std::string out;
  out.reserve(json.size() + json.size() / 16);
  for (const char c : json) {
    if (c == '<' || c == '>' || c == '&')
      out += "\\u" + hex(static_cast<unsigned char>(c), 4);
    else
      out += c;
  }
  return out;
}

std::size_t display_width(std::string_view text) {
  std::size_t width = 0;
  while (!text.empty()) {
    const Decoded next = decode(text);
    width += next.valid ? width_of(next.code) : 1;
    text.remove_prefix(next.size);
  }
  return width;
}

std::string fitted(std::string_view text, std::size_t width) {
  if (display_width(text) <= width) return std::string(text);
  if (width == 0) return {};
  std::string out;
  std::size_t used = 0;
  while (!text.empty()) {
    const Decoded next = decode(text);
    const std::size_t columns = next.valid ? width_of(next.code) : 1;
    if (used + columns > width - 1) break;
    out += text.substr(0, next.size);
    used += columns;
    text.remove_prefix(next.size);
  }
  return out + "\xe2\x80\xa6";
}

std::string padded(std::string_view text, std::size_t width) {
  std::string out = fitted(text, width);
  out.append(width - std::min(width, display_width(out)), ' ');
  return out;
}

}  // namespace backbend::validate
