#pragma once
#include <string_view>

#include "render/image/picture.h"

namespace backbend::render {

enum class Align { left, center, right };

/// Width in pixels of `text` at a font size in pixels. Throws RenderError without the font
/// (DejaVu Sans, Debian's fonts-dejavu-core).
int text_width(std::string_view text, int size);

/// Height of one line of text, the same for every text of a size.
int line_height(int size);

/// Writes one line of UTF-8 with its upper edge at y; x is its left edge, middle or right edge.
/// Control characters are dropped, accents left out, a degree sign is written ` deg`; characters
/// past Latin-1 and ill-formed UTF-8 are shown as `?` (the library draws ASCII only).
void draw_text(Picture& picture, int x, int y, std::string_view text, int size, Color8 color,
               Align align = Align::left);

/// `text` cut to `width` pixels at a font size, its end replaced by three dots where it is too
/// long.
std::string fit_text(std::string_view text, int size, int width);

}  // namespace backbend::render
