#pragma once
#include <string>

#include "validate/model/report.h"

namespace backbend::validate {

/// The findings as CSV (RFC 4180: CRLF, a header line), one row each in the report's order. Numbers
/// are plain; a text that a spreadsheet would run as a formula is made harmless (see csv_text).
std::string findings_csv(const Report& report);

/// The sweeps as CSV: one row per rig, sweep and pose, one column per metric of the whole report;
/// an empty cell is what was not measured.
std::string sweeps_csv(const Report& report);

}  // namespace backbend::validate
