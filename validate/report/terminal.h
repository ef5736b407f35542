#pragma once
#include <string>

#include "validate/model/report.h"
#include "validate/text/terminal_style.h"

namespace backbend::validate {

/// The end of a run as a person reads it: headroom per channel with bars, counts, the worst
/// findings with place and owner, canaries, detectors, where the page is and what to type next.
/// Ends with a line feed; no line is wider than the style allows, except paths and commands, which
/// must stay whole to be copied. Names are shown with every control character spelled out.
std::string terminal_summary(const Report& report, const TerminalStyle& style = {});

/// Only the report's comparisons, each in full.
std::string comparisons_text(const Report& report, const TerminalStyle& style = {});

}  // namespace backbend::validate
