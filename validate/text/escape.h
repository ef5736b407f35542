#pragma once
#include <cstddef>
#include <string>
#include <string_view>

namespace backbend::validate {

/// Names come from files that anyone may have written. Each function makes one safe for one place.
/// All take any bytes and give valid UTF-8; what cannot be shown is spelled out (`\x1b`, `\u202e`),
/// so that a name never acts and never hides.

/// Characters that act are spelled out: controls (newline and tab too), characters that turn the
/// direction of text or take no room, private use, and bytes that are not UTF-8. Everything else
/// stays.
std::string visible(std::string_view text);
/// Only bytes that are not UTF-8 change, to U+FFFD.
std::string valid_utf8(std::string_view text);

/// For HTML and XML, in text and in quoted attributes alike. The result of `visible` inside, hence
/// free of characters that XML 1.0 forbids.
std::string markup_text(std::string_view text);
/// A Markdown code span, in which GitHub reads no markup, mention, issue number or link; fit for a
/// table cell. An empty text gives a dash.
std::string markdown_code(std::string_view text);
/// A CSV cell (RFC 4180). A text that a spreadsheet would take for a formula gets a leading `'`.
std::string csv_text(std::string_view text);
/// A JSON string with its quotes.
std::string json_text(std::string_view text);
/// JSON made fit to stand inside an HTML script element: no `<`, `>` or `&` is left. Same value.
std::string json_for_script(std::string_view json);

/// Columns a terminal uses for `text` (already `visible`): 2 for wide characters, 0 for combining.
std::size_t display_width(std::string_view text);
/// `text` cut to `width` columns, ending in an ellipsis where something was cut.
std::string fitted(std::string_view text, std::size_t width);
/// `fitted`, then filled with blanks to exactly `width` columns.
std::string padded(std::string_view text, std::size_t width);

}  // namespace backbend::validate
