#include "render/image/text.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <utility>

#include "render/image/picture_library.h"

namespace backbend::render {
namespace {

/// Where Debian installs the font, whose place not every release's library knows; else its name.
const std::string& font() {
  static const std::string found = [] {
    const std::string file = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";
    std::error_code error;
    return std::filesystem::is_regular_file(file, error) ? file : std::string("DejaVuSans");
  }();
  return found;
}

// U+00C0 to U+00FF without their accents.
constexpr char kUnaccented[] = "AAAAAAACEEEEIIIIDNOOOOOxOUUUUYTsaaaaaaaceeeeiiiidnooooo/ouuuuyty";
static_assert(sizeof kUnaccented == 65);

// Length of the well-formed UTF-8 sequence at the head of `text`, or 0.
std::size_t sequence_length(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const std::size_t length = byte(0) < 0x80         ? 1
                             : byte(0) >> 5 == 0x06 ? 2
                             : byte(0) >> 4 == 0x0e ? 3
                             : byte(0) >> 3 == 0x1e ? 4
                                                    : 0;
  if (length == 0 || length > text.size()) return 0;
  for (std::size_t i = 1; i < length; ++i)
    if (byte(i) >> 6 != 0x02) return 0;
  return length;
}

// Names come from files of others: whatever they hold, the text stays one printable line. The
// library (2.4) draws everything past ASCII as something else, so it becomes what ASCII has for it.
std::string printable(std::string_view text) {
  std::string out;
  while (!text.empty()) {
    const std::size_t length = sequence_length(text);
    const auto first = static_cast<unsigned char>(text[0]);
    const std::string_view character = text.substr(0, length);
    if (character == "\u2026") {
      out += "...";
    } else if (character == "\u00b0") {
      out += " deg";
    } else if (length == 2 && first == 0xc3) {
      out += kUnaccented[static_cast<unsigned char>(character[1]) & 63u];
    } else if (character == "\u2013" || character == "\u2014" || character == "\u2212") {
      out += '-';
    } else if (length == 0 || first >= 0x80) {
      out += '?';
    } else if (first >= 0x20 && first != 0x7f) {
      out += character;
    }
    text.remove_prefix(std::max<std::size_t>(length, 1));
  }
  return out;
}

/// Frames of a sequence have most of their texts in common: widths are kept.
class TextWidths {
 public:
  std::optional<int> find(const std::string& text, int size) {
    const std::lock_guard lock(mutex_);
    const auto found = width_.find({text, size});
    if (found == width_.end()) return std::nullopt;
    return found->second;
  }
  void keep(const std::string& text, int size, int width) {
    constexpr std::size_t kMost = 4096;
    const std::lock_guard lock(mutex_);
    if (width_.size() >= kMost) width_.clear();
    width_[{text, size}] = width;
  }

 private:
  std::mutex mutex_;
  std::map<std::pair<std::string, int>, int> width_;
};

int measure(const std::string& text, int size) {
  static TextWidths known;
  if (const std::optional<int> width = known.find(text, size)) return *width;
  const int width = picture_library().text_width(text, size, font());
  if (width < 0)
    throw RenderError("text: the font DejaVuSans is missing; install fonts-dejavu-core");
  known.keep(text, size, width);
  return width;
}

}  // namespace

int text_width(std::string_view text, int size) {
  const std::string line = printable(text);
  return line.empty() ? 0 : measure(line, size);
}

int line_height(int size) { return size + size / 3; }

void draw_text(Picture& picture, int x, int y, std::string_view text, int size, Color8 color,
               Align align) {
  const std::string line = printable(text);
  if (line.empty()) return;
  const int width = measure(line, size);
  if (align == Align::center) x -= width / 2;
  if (align == Align::right) x -= width;
  // On a label of its own, in the text's colour throughout: the library fails on text that leaves
  // the picture, and blends alpha like a colour.
  const int margin = size / 4 + 1;
  Picture label(width + 2 * margin, line_height(size), {color[0], color[1], color[2], 0});
  const float rgba[4] = {color[0] / 255.0f, color[1] / 255.0f, color[2] / 255.0f,
                         color[3] / 255.0f};
  // The library wants the baseline; capitals of this font are about 0.73 of its size tall.
  const int baseline = (line_height(size) + size * 73 / 100) / 2;
  const std::string wrong = picture_library().draw_text(
      label.rgba.data(), label.width, label.height, margin, baseline, line, size, font(), rgba);
  if (!wrong.empty()) throw RenderError("text: " + wrong);
  blit(picture, label, x - margin, y);
}

std::string fit_text(std::string_view text, int size, int width) {
  const std::string line = printable(text);  // one byte a character
  if (text_width(line, size) <= width) return line;
  std::size_t fits = 0, over = line.size();  // characters that go in front of the dots
  while (over > fits + 1) {
    const std::size_t middle = (fits + over) / 2;
    (text_width(line.substr(0, middle) + "...", size) <= width ? fits : over) = middle;
  }
  if (fits == 0 && text_width("...", size) > width) return {};
  return line.substr(0, fits) + "...";
}

}  // namespace backbend::render
