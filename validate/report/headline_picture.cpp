#include "validate/report/headline_picture.h"

#include <algorithm>
#include <sstream>

#include "render/image/png.h"
#include "render/image/text.h"
#include "render/review/sheet.h"
#include "validate/model/digest.h"
#include "validate/report/handoff.h"
#include "validate/text/escape.h"
#include "validate/text/number_text.h"
#include "validate/verdicts/names.h"

namespace backbend::validate {
namespace {

using render::Color8;
using render::Picture;

constexpr int kPictureWidth = 1200, kPictureHeight = 630, kMargin = 56, kGap = 32;
constexpr int kFrameWidth = 480;  // of the finding's picture
constexpr Color8 kGround{22, 25, 32, 255}, kInk{236, 239, 244, 255},
    kQuietColor{154, 163, 178, 255};
constexpr Color8 kTrack{46, 52, 64, 255}, kGood{72, 178, 120, 255}, kBad{226, 84, 84, 255};
constexpr Color8 kUnsure{232, 176, 66, 255};

Color8 color_of(Verdict verdict) {
  if (verdict == Verdict::pass) return kGood;
  return verdict == Verdict::fail ? kBad : kUnsure;
}

void fill(Picture& to, int x, int y, int width, int height, Color8 color) {
  if (width > 0) render::blit(to, Picture(width, height, color), x, y);
}

/// Writes a text on at most two lines, broken at a space where there is one, and returns where the
/// next one begins.
int write(Picture& to, int x, int y, int width, const std::string& text, int size, Color8 color) {
  std::string first = fitted(text, 200), second;
  if (render::text_width(first, size) > width) {
    std::size_t space = first.rfind(' ');
    while (space != std::string::npos && space > 0 &&
           render::text_width(first.substr(0, space), size) > width)
      space = first.rfind(' ', space - 1);
    if (space != std::string::npos && space > 0) {
      second = first.substr(space + 1);
      first.resize(space);
    }
  }
  for (const std::string& line : {first, second}) {
    if (line.empty()) continue;
    render::draw_text(to, x, y, render::fit_text(line, size, width), size, color);
    y += render::line_height(size);
  }
  return y;
}

/// A bar for each channel: how far it is clean, with a mark at what it needs.
int draw_headroom(Picture& to, int x, int y, int width, const RigResult& rig) {
  constexpr int kSize = 20, kName = 130, kNumbers = 170, kBar = 14, kMost = 5;
  const int bar = width - kName - kNumbers;
  int rows = 0;
  for (const Headroom& h : rig.headroom) {
    if (!h.measured || rows++ == kMost) continue;
    const bool enough = h.headroom_deg() >= 0.0;
    const double whole = std::max({h.clean_to_deg, h.needs_deg, 1.0});
    const int top = y + (render::line_height(kSize) - kBar) / 2;
    render::draw_text(to, x, y, render::fit_text(fitted(visible(h.channel), 40), kSize, kName - 10),
                      kSize, kQuietColor);
    fill(to, x + kName, top, bar, kBar, kTrack);
    fill(to, x + kName, top, int(bar * std::max(0.0, h.clean_to_deg) / whole), kBar,
         enough ? kGood : kBad);
    fill(to, x + kName + int((bar - 3) * h.needs_deg / whole), top - 4, 3, kBar + 8, kInk);
    render::draw_text(to, x + width, y,
                      fixed(h.clean_to_deg, 0) + " of " + fixed(h.needs_deg, 0) + " deg", kSize,
                      enough ? kInk : kBad, render::Align::right);
    y += render::line_height(kSize) + 6;
  }
  return y;
}

/// The picture, and the words under it, of the worst finding that has a frame.
struct Shown {
  Picture picture;
  std::string label;
};
Shown worst_frame(const Report& report, const PictureBytes& bytes) {
  const Digest digest(report);
  for (const Finding* finding : digest.worst(report.findings.size())) {
    const FindingPictures& own = finding->pictures;
    const std::string& path = own.after.empty() ? own.before : own.after;
    const auto file = bytes && !path.empty() ? bytes(path) : std::nullopt;
    if (!file) continue;
    try {
      return {render::shrink(render::decode_png(*file), kFrameWidth, kPictureHeight - 3 * kMargin),
              visible(finding->code + ", " + std::string(role_word(digest.role_of(*finding))) +
                      " " + finding->rig + " at " + finding->pose)};
    } catch (const render::RenderError&) {
      continue;  // the page says what is wrong with it; here another one stands in
    }
  }
  return {};
}

}  // namespace

std::vector<std::uint8_t> headline_png(const Report& report, const PictureBytes& bytes) {
  Picture card(kPictureWidth, kPictureHeight, kGround);
  const Color8 color = color_of(report.verdict);
  fill(card, 0, 0, 16, kPictureHeight, color);

  const Shown shown = worst_frame(report, bytes);
  const bool has_frame = shown.picture.width > 0;
  const int width = kPictureWidth - 2 * kMargin - (has_frame ? kFrameWidth + kGap : 0);
  std::string word(verdict_word(report.verdict));
  std::ranges::replace(word, '_', ' ');
  std::ranges::transform(word, word.begin(), [](unsigned char c) { return std::toupper(c); });
  int y = write(card, kMargin, kMargin - 16, width, word, 76, color) + 4;
  y = write(card, kMargin, y, width, visible(report.title), 28, kInk) + 14;

  const auto proposed = std::ranges::find(report.rigs, Role::proposed, &RigResult::role);
  std::string drawn;
  if (proposed != report.rigs.end()) {
    drawn = visible(proposed->rig) + " (" + visible(proposed->mapping) + ") on " +
            visible(proposed->character);
    y = write(card, kMargin, y, width, drawn, 22, kQuietColor) + 8;
    y = draw_headroom(card, kMargin, y, width, *proposed) + 12;
  }
  const int frame_end = kMargin + shown.picture.height + 10 + render::line_height(20);
  std::istringstream lines(headline_text(report));
  std::string line;
  std::getline(lines, line);  // verdict and title stand above
  while (std::getline(lines, line) && y + render::line_height(20) < kPictureHeight - 40) {
    const bool has_bar = !drawn.empty() && line.starts_with(drawn + ": ");
    const int room = y < frame_end ? width : kPictureWidth - 2 * kMargin;
    if (!has_bar) y = write(card, kMargin, y, room, line, 20, kInk) + 4;
  }

  if (has_frame) {
    const int x = kPictureWidth - kMargin - kFrameWidth;
    render::blit(card, shown.picture, x + (kFrameWidth - shown.picture.width) / 2, kMargin);
    write(card, x, kMargin + shown.picture.height + 10, kFrameWidth, shown.label, 20, kQuietColor);
  }
  render::draw_text(card, kPictureWidth - kMargin, kPictureHeight - 44, "backbend", 20, kQuietColor,
                    render::Align::right);
  return render::encode_png(card);
}

}  // namespace backbend::validate
