#pragma once
#include <string>

#include "validate/history/trend.h"
#include "validate/text/terminal_style.h"

namespace backbend::validate {

/// A row of marks, one per value and at most `width`, lowest to highest; a blank where nothing was
/// measured. More values than columns: the last ones are shown.
std::string sparkline(const std::vector<double>& values, std::size_t width, bool unicode);

/// One line per trend (name, spark, last value) and under it its steps, those for the worse in red.
/// A single trend is drawn as a plot of several lines. No line is wider than the style allows.
std::string history_text(const TrendTable& table, const TerminalStyle& style);

/// Since when a check fails: the version where it began, the last good one, where it recovered.
std::string onset_text(const std::string& character, const std::string& code, const Onset& onset,
                       const TerminalStyle& style);

}  // namespace backbend::validate
