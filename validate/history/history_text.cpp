#include "validate/history/history_text.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "validate/text/escape.h"
#include "validate/text/number_text.h"

namespace backbend::validate {
namespace {

constexpr std::array<const char*, 8> kBlocks{"\xe2\x96\x81", "\xe2\x96\x82", "\xe2\x96\x83",
                                             "\xe2\x96\x84", "\xe2\x96\x85", "\xe2\x96\x86",
                                             "\xe2\x96\x87", "\xe2\x96\x88"};
/// Marks that stand at rising heights of their cell.
constexpr std::array<const char*, 5> kPlain{"_", ".", "-", "'", "^"};
constexpr std::size_t kPlotRows = 8;

struct ValueRange {
  double low = 0, high = 0;
  bool any = false;
};
ValueRange range_of(const std::vector<double>& values, std::size_t from) {
  ValueRange range;
  for (std::size_t i = from; i < values.size(); ++i) {
    if (!std::isfinite(values[i])) continue;
    range.low = range.any ? std::min(range.low, values[i]) : values[i];
    range.high = range.any ? std::max(range.high, values[i]) : values[i];
    range.any = true;
  }
  return range;
}

/// Which of `count` levels a value has in a range; the middle where the range is a point.
std::size_t level(double value, const ValueRange& range, std::size_t count) {
  if (!(range.high > range.low)) return count / 2;
  const double part = (value - range.low) / (range.high - range.low);
  return std::min(count - 1, static_cast<std::size_t>(part * static_cast<double>(count)));
}

std::string colored(const TerminalStyle& style, const char* code, const std::string& text) {
  return style.color ? std::string("\x1b[") + code + "m" + text + "\x1b[0m" : text;
}

std::string trend_name(const Trend& t) {
  return visible(t.character) + " " + visible(t.rig) + (t.mapping.empty() ? "" : "/") +
         visible(t.mapping) + " " + visible(t.metric);
}

std::string steps_text(const Trend& trend, const TerminalStyle& style, std::size_t width) {
  std::string text;
  for (const TrendStep& step : trend.steps) {
    std::string line = std::string(step.worse ? "worse" : "better") + " from " +
                       visible(step.version) + ": " + significant(step.before) + " -> " +
                       significant(step.after) + " " + visible(trend.unit);
    if (!step.last_before.empty()) line += ", last before " + visible(step.last_before);
    if (!step.recovered.empty()) line += ", recovered at " + visible(step.recovered);
    const char* ink = !step.worse ? "32" : step.recovered.empty() ? "31;1" : "33";
    text += "    " + colored(style, ink, fitted(line, width - 4)) + "\n";
  }
  return text;
}

std::string plot(const Trend& trend, const TerminalStyle& style, std::size_t width) {
  constexpr std::size_t kAxis = 10;
  const std::size_t columns = std::min(trend.value.size(), width - kAxis - 1);
  const std::size_t from = trend.value.size() - columns;
  const ValueRange range = range_of(trend.value, from);
  std::string text;
  for (std::size_t row = kPlotRows; row-- > 0;) {
    const std::string mark = !range.any             ? ""
                             : row == kPlotRows - 1 ? significant(range.high)
                             : row == 0             ? significant(range.low)
                                                    : "";
    text += std::string(kAxis - std::min(kAxis, mark.size()), ' ') + mark + "|";
    std::string line;
    for (std::size_t c = 0; c < columns; ++c) {
      const double value = trend.value[from + c];
      const bool here = std::isfinite(value) && level(value, range, kPlotRows) == row;
      line += here ? (style.unicode ? "\xe2\x97\x8f" : "*") : " ";
    }
    text += line.substr(0, line.find_last_not_of(' ') + 1) + "\n";
  }
  return text;
}

}  // namespace

std::string sparkline(const std::vector<double>& values, std::size_t width, bool unicode) {
  const std::size_t from = values.size() - std::min(values.size(), width);
  const ValueRange range = range_of(values, from);
  std::string text;
  for (std::size_t i = from; i < values.size(); ++i) {
    if (!std::isfinite(values[i]))
      text += ' ';
    else
      text += unicode ? kBlocks[level(values[i], range, kBlocks.size())]
                      : kPlain[level(values[i], range, kPlain.size())];
  }
  return text;
}

std::string history_text(const TrendTable& table, const TerminalStyle& style) {
  const auto width = static_cast<std::size_t>(std::max(40, style.width));
  if (table.nights.empty()) return "no nights yet\n";
  std::string text =
      fitted(std::to_string(table.nights.size()) + " nights, " + visible(table.nights.front()) +
                 " to " + visible(table.nights.back()),
             width) +
      "\n";
  if (table.trends.size() == 1) {
    const Trend& trend = table.trends.front();
    text += fitted(trend_name(trend) + (trend.unit.empty() ? "" : ", ") + visible(trend.unit) +
                       (trend.more_is_worse ? "; lower is better" : "; higher is better"),
                   width) +
            "\n" + plot(trend, style, width) + steps_text(trend, style, width);
    return text;
  }
  const std::size_t spark = std::min<std::size_t>(30, width / 3), value = 10;
  const std::size_t names = width - spark - value - 4;
  for (const Trend& trend : table.trends) {
    const double last = trend.value.empty() ? std::nan("") : trend.value.back();
    const std::string line = sparkline(trend.value, spark, style.unicode);
    const std::size_t shown = std::min(spark, trend.value.size());
    text += "  " + padded(trend_name(trend), names) + " " + std::string(spark - shown, ' ') + line +
            " " + fitted(std::isfinite(last) ? significant(last) : "-", value) + "\n" +
            steps_text(trend, style, width);
  }
  return text;
}

std::string onset_text(const std::string& character, const std::string& code, const Onset& onset,
                       const TerminalStyle& style) {
  const NightFailure& f = onset.worst;
  std::string text = visible(code) + " on " + visible(character) + " began at " +
                     colored(style, "31;1", visible(name_of(*onset.first_bad))) + "\n";
  const auto version = [&](const Night& night) {
    return "file " + visible(night.version.at(character)) + ", report " + visible(night.report);
  };
  text += "  first bad  " + version(*onset.first_bad) + "\n";
  text += "             " + visible(f.rig) + (f.mapping.empty() ? "" : "/") + visible(f.mapping) +
          " at " + visible(f.pose) + ": " + significant(f.value) + "\n";
  text += onset.last_good == nullptr ? "  last good  none on record\n"
                                     : "  last good  " + visible(name_of(*onset.last_good)) + ", " +
                                           version(*onset.last_good) + "\n";
  text += onset.recovered == nullptr
              ? "  it still fails, " + std::to_string(onset.bad_nights) +
                    (onset.bad_nights == 1 ? " night\n" : " nights\n")
              : "  recovered at " + visible(name_of(*onset.recovered)) + "\n";
  return text;
}

}  // namespace backbend::validate
