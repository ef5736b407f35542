#pragma once
#include <stdexcept>
#include <string>
#include <string_view>

#include "validate/model/report.h"

namespace backbend::validate {

/// A report file that cannot be used. what() names the file, the place as a JSON path
/// (`$.rigs[1].headroom[0].needs_deg`), what was found and what was expected.
struct ReportError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

inline constexpr std::string_view kReportSchemaName = "backbend.report/1";

/// The report as JSON text, schema `backbend.report/1`: keys sorted, numbers in the shortest form
/// that reads back exactly, what is not finite as null, one line per array of plain values so that
/// two nights compare line by line. The same report gives the same bytes.
std::string report_json(const Report& report);

/// The same value on one line.
std::string report_json_compact(const Report& report);

/// Content hash of one finding as report.json holds it: what an approval speaks of.
std::string finding_hash(const Finding& finding);

/// Comparisons alone, as in the report.
std::string comparisons_json(const std::vector<Comparison>& comparisons);

/// Fills in which rig and sweep each finding is of, by their names: all that a file has of them.
/// Where two have one name, the first.
void number_findings(Report& report);

/// The inverse: parse_report(report_json(r)) gives r, with null read as NaN.
///
/// `name` is what errors call the text. Throws ReportError on anything the schema does not allow:
/// unknown or missing keys, doubled keys, wrong types, words outside an enumeration, series of
/// unequal lengths, derived values (headroom, canary `ok`, coverage sums) that do not follow.
Report parse_report(std::string_view text, std::string_view name = "report.json");

/// The published draft-07 schema of the above, as text.
std::string_view report_schema();

}  // namespace backbend::validate
