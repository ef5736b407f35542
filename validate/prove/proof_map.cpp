#include "validate/prove/proof_map.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "validate/sweeps/suite.h"

namespace backbend::validate {
namespace {

std::string painted(const std::string& row, bool color) {
  if (!color) return row;
  std::string text;
  char before = 0;
  for (const char c : row) {
    if (c != before)
      text += c == ProofMap::kCertified ? "\033[32m"
              : c == ProofMap::kRefuted ? "\033[31m"
                                        : "\033[90m";
    text += before = c;
  }
  return text + "\033[0m";
}

}  // namespace

ProofMap::ProofMap(const ProofBox& box, std::size_t columns)
    : box_(box), up_(std::min<std::size_t>(1, box.axis.size() - 1)), along_(box.axis.size() - 1) {
  constexpr std::size_t kRows = 9, kBands = 5;
  const auto cells = [&](std::size_t axis, std::size_t most) {
    return box.axis[axis].varies() ? most : 1;
  };
  rows_ = up_ == 0 ? 1 : cells(up_, kRows);
  columns_ = cells(0, columns);
  const std::size_t bands = along_ < 2 ? 1 : cells(along_, kBands);
  for (std::size_t b = 0; b < bands; ++b) {
    const ProofAxis& axis = box.axis[along_];
    const double step = along_ < 2 ? 0.0 : axis.width() / double(bands);
    band_.push_back({axis.low + step * double(b), axis.low + step * double(b + 1),
                     std::vector<std::string>(rows_, std::string(columns_, kCertified))});
  }
}

void ProofMap::mark(const SubBox& part, char state) {
  // The cells that a part of an axis meets with more than an edge.
  const auto range = [&](std::size_t axis, std::size_t count) {
    const ProofAxis& whole = box_.axis[axis];
    if (count == 1) return std::pair<std::size_t, std::size_t>{0, 0};
    const auto cell = [&](double at) { return (at - whole.low) / whole.width() * double(count); };
    const double first = std::floor(cell(part.low[axis]) + 1e-9),
                 last = std::ceil(cell(part.high[axis]) - 1e-9) - 1.0;
    const auto most = double(count - 1);
    return std::pair<std::size_t, std::size_t>{std::size_t(std::clamp(first, 0.0, most)),
                                               std::size_t(std::clamp(last, 0.0, most))};
  };
  const auto [c0, c1] = range(0, columns_);
  const auto [r0, r1] = range(up_, rows_);
  const auto [b0, b1] = range(along_, band_.size());
  for (std::size_t b = b0; b <= b1; ++b) {
    for (std::size_t r = r0; r <= r1; ++r) {
      for (std::size_t c = c0; c <= c1; ++c) {
        char& cell = band_[b].row[rows_ - 1 - r][c];
        if (state == kRefuted || cell == kCertified) cell = state;
      }
    }
  }
}

std::size_t map_columns(const TerminalStyle& style) {
  return static_cast<std::size_t>(std::clamp(style.width - 4, 20, 60));
}

std::string map_text(const ProofMap& map, const ProofBox& box, const TerminalStyle& style) {
  const auto range = [&](std::size_t axis) {
    return box.axis[axis].channel + " " + number_text(box.axis[axis].low) + ".." +
           number_text(box.axis[axis].high);
  };
  std::string text = "across: " + range(0);
  if (map.up() != 0) text += ", up: " + range(map.up());
  text += "; " + std::string(1, ProofMap::kCertified) + " certified, " + ProofMap::kRefuted +
          " refuted, " + ProofMap::kOpen + " open\n";
  for (const ProofMap::Band& band : map.bands()) {
    if (map.bands().size() > 1) {
      text += box.axis[map.along()].channel + " " + number_text(band.low) + ".." +
              number_text(band.high) + "\n";
    }
    for (const std::string& row : band.row) text += "  " + painted(row, style.color) + "\n";
  }
  return text;
}

std::string share_text(double share) {
  if (share == 0.0) return "0 %";
  if (share >= 1.0) return "100 %";
  if (share > 0.9999) return "over 99.99 %";
  if (share < 0.0001) return "under 0.01 %";
  return number_text(100.0 * share, 2) + " %";
}

}  // namespace backbend::validate
