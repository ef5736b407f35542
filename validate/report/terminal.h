#pragma once
#include <string>

#include "validate/report/report.h"

namespace backbend::validate {

struct TerminalStyle {
  int width = 80;       // columns; at least 40 is used
  bool color = false;   // ANSI colours; the caller knows about NO_COLOR and terminals
  bool unicode = true;  // false: bars and marks in ASCII
  int worst = 3;        // how many findings are shown with detail
  std::string page;     // path of the report's page as the user may open it; empty: no line
};

/// The end of a run as a person reads it: headroom per channel with bars, counts, the worst
/// findings with place and owner, canaries, detectors, where the page is and what to type next.
/// Ends with a line feed; no line is wider than the style allows, except paths and commands, which
/// must stay whole to be copied. Names are shown with every control character spelled out.
std::string terminal_summary(const Report& report, const TerminalStyle& style = {});

/// Only the report's comparisons, each in full.
std::string comparisons_text(const Report& report, const TerminalStyle& style = {});

}  // namespace backbend::validate
