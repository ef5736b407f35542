#include "render/review/sheet.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <numeric>

#include "render/image/heat_map.h"
#include "render/image/text.h"

namespace backbend::render {
namespace {

constexpr Color8 kPaper{244, 245, 246, 255}, kInk{28, 31, 36, 255}, kWarning{196, 84, 0, 255};
constexpr Color8 kStrip{16, 18, 22, 190}, kLight{245, 246, 248, 255};

void fill(Picture& picture, int x, int y, int width, int height, Color8 color) {
  if (width < 1 || height < 1) return;
  blit(picture, Picture(width, height, color), x, y);
}

// Shortest digits that name the value to three figures, without exponent where it is readable.
std::string number(float value) {
  if (!std::isfinite(value)) return "not finite";
  std::array<char, 32> text;
  const auto [end, error] =
      std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::general, 3);
  return error == std::errc{} ? std::string(text.data(), end) : "?";
}

int text_size_for(const Picture& picture) {
  return std::clamp(std::min(picture.width, picture.height) / 22, 9, 40);
}

Color8 heat_byte(float t) {
  const glm::vec3 c = heat_color(t);
  const auto byte = [](float v) {
    return static_cast<std::uint8_t>(srgb_from_linear(v) * 255.0f + 0.5f);
  };
  return {byte(c.x), byte(c.y), byte(c.z), 255};
}

}  // namespace

Picture contact_sheet(std::span<const SheetCell> cells, int columns, std::string_view title) {
  if (cells.empty() || columns < 1) throw RenderError("contact sheet: there is nothing to show");
  const int count = static_cast<int>(cells.size());
  columns = std::min(columns, count);
  int width = 1;
  bool labelled = false;
  std::vector<int> row_height((count + columns - 1) / columns, 1);
  for (int i = 0; i < count; ++i) {
    width = std::max(width, cells[i].picture.width);
    row_height[i / columns] = std::max(row_height[i / columns], cells[i].picture.height);
    labelled = labelled || !cells[i].label.empty();
  }
  const int text = std::clamp(width / 20, 10, 22), gap = std::max(4, width / 40), frame = 3;
  const int below = (labelled ? line_height(text) : 0) + gap;
  int y = title.empty() ? gap : gap + line_height(text + 4) + gap / 2;
  const int height = std::accumulate(row_height.begin(), row_height.end(), y) +
                     static_cast<int>(row_height.size()) * below;
  Picture sheet(columns * (width + gap) + gap, height, kPaper);
  if (!title.empty())
    draw_text(sheet, gap, gap / 2, fit_text(title, text + 4, sheet.width - 2 * gap), text + 4,
              kInk);
  for (int i = 0; i < count; ++i) {
    const SheetCell& cell = cells[i];
    const int tall = row_height[i / columns];
    const int x = gap + i % columns * (width + gap);
    const int left = x + (width - cell.picture.width) / 2,
              upper = y + (tall - cell.picture.height) / 2;
    if (cell.highlighted)
      fill(sheet, left - frame, upper - frame, cell.picture.width + 2 * frame,
           cell.picture.height + 2 * frame, kWarning);
    blit(sheet, cell.picture, left, upper);
    draw_text(sheet, x + width / 2, y + tall + frame, fit_text(cell.label, text, width), text,
              cell.highlighted ? kWarning : kInk, Align::center);
    if (i % columns == columns - 1) y += tall + below;
  }
  return sheet;
}

Picture side_by_side(const Picture& left, std::string_view left_name, const Picture& right,
                     std::string_view right_name) {
  constexpr int kGap = 4;
  Picture both(left.width + kGap + right.width, std::max(left.height, right.height), kPaper);
  blit(both, left, 0, 0);
  blit(both, right, left.width + kGap, 0);
  const auto name = [&](const Picture& side, int x, std::string_view text) {
    const int size = text_size_for(side), pad = size / 2;
    const std::string shown = fit_text(text, size, side.width - 2 * pad);
    if (shown.empty()) return;
    fill(both, x, 0, text_width(shown, size) + 2 * pad, line_height(size), kStrip);
    draw_text(both, x + pad, 0, shown, size, kLight);
  };
  name(left, 0, left_name);
  name(right, left.width + kGap, right_name);
  return both;
}

int burn_in(Picture& picture, std::string_view left, std::string_view middle,
            std::string_view right) {
  int size = text_size_for(picture);
  const auto needed = [&] {
    return text_width(left, size) + text_width(middle, size) + text_width(right, size) + 3 * size;
  };
  while (size > 9 && needed() > picture.width) --size;
  const int pad = size / 2, height = line_height(size), y = picture.height - height;
  fill(picture, 0, y, picture.width, height, kStrip);
  // Where even small letters are too many, each text keeps a third.
  const int most = needed() > picture.width ? picture.width / 3 - pad : picture.width;
  const std::string first = fit_text(left, size, most), last = fit_text(right, size, most);
  const int from = pad + text_width(first, size);
  const int to = picture.width - pad - text_width(last, size);
  draw_text(picture, pad, y, first, size, kLight);
  draw_text(picture, (from + to) / 2, y, fit_text(middle, size, most), size, kLight, Align::center);
  draw_text(picture, picture.width - pad, y, last, size, kLight, Align::right);
  return height;
}

void draw_legend(Picture& picture, float low, float high, std::string_view label,
                 int above_bottom) {
  const int size = std::max(9, text_size_for(picture) * 3 / 4), pad = size / 2, bar = size;
  const int line = line_height(size);
  const int width = std::clamp(picture.width / 3, std::min(picture.width - 2 * pad, 120), 420);
  const int height = bar + 3 * line + pad;
  const int x = pad, y = picture.height - above_bottom - height - pad;
  fill(picture, x - pad, y, width + 2 * pad, height + pad, kStrip);
  draw_text(picture, x, y, fit_text(label, size, width), size, kLight);
  for (int i = 0; i < width; ++i)
    fill(picture, x + i, y + line, 1, bar, heat_byte((static_cast<float>(i) + 0.5f) / width));
  const int below = y + line + bar;
  draw_text(picture, x, below, number(low), size, kLight);
  draw_text(picture, x + width / 2, below, number(0.5f * (low + high)), size, kLight,
            Align::center);
  draw_text(picture, x + width, below, number(high), size, kLight, Align::right);
  fill(picture, x, below + line + line / 4, bar, bar, heat_byte(std::nanf("")));
  draw_text(picture, x + bar + pad, below + line, fit_text("not measured", size, width - bar - pad),
            size, kLight);
}

Picture shrink(const Picture& picture, int width, int height) {
  if (picture.rgba.empty() || width < 1 || height < 1) throw RenderError("shrink: nothing to show");
  const double scale = std::min({1.0, static_cast<double>(width) / picture.width,
                                 static_cast<double>(height) / picture.height});
  if (scale >= 1.0) return picture;
  Picture small(std::max(1, static_cast<int>(picture.width * scale + 0.5)),
                std::max(1, static_cast<int>(picture.height * scale + 0.5)), {0, 0, 0, 0});
  std::array<float, 256> linear;
  for (int i = 0; i < 256; ++i) linear[i] = linear_from_srgb(static_cast<float>(i) / 255.0f);
  const double step_x = static_cast<double>(picture.width) / small.width;
  const double step_y = static_cast<double>(picture.height) / small.height;
  for (int y = 0; y < small.height; ++y) {
    for (int x = 0; x < small.width; ++x) {
      const double left = x * step_x, right = left + step_x, top = y * step_y,
                   bottom = top + step_y;
      float sum[4] = {}, total = 0.0f;
      for (int sy = static_cast<int>(top); sy < bottom && sy < picture.height; ++sy) {
        const double rows = std::min(bottom, sy + 1.0) - std::max(top, static_cast<double>(sy));
        for (int sx = static_cast<int>(left); sx < right && sx < picture.width; ++sx) {
          const double columns =
              std::min(right, sx + 1.0) - std::max(left, static_cast<double>(sx));
          const auto area = static_cast<float>(rows * columns);
          const std::uint8_t* in = picture.at(sx, sy);
          const float alpha = static_cast<float>(in[3]) / 255.0f * area;
          for (int c = 0; c < 3; ++c) sum[c] += linear[in[c]] * alpha;
          sum[3] += alpha;
          total += area;
        }
      }
      std::uint8_t* out = small.at(x, y);
      for (int c = 0; c < 3; ++c)
        out[c] = static_cast<std::uint8_t>(
            srgb_from_linear(sum[3] > 0.0f ? sum[c] / sum[3] : 0.0f) * 255.0f + 0.5f);
      out[3] = static_cast<std::uint8_t>(std::min(1.0f, sum[3] / total) * 255.0f + 0.5f);
    }
  }
  return small;
}

}  // namespace backbend::render
