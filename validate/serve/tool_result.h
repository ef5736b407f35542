#pragma once
#include <string>
#include <string_view>

#include "validate/serve/mcp_session.h"

namespace backbend::validate {

/// Findings that a result lists; what it leaves out is counted.
inline constexpr std::size_t kMostListed = 50;

/// What a command printed with --json, as a client gets it: an object with `exit_code`, and of a
/// report the part that a reader acts on. Left out are series of numbers for each pose, names of
/// pictures and the legend, which `explain` and `list` have; long lists are cut to `kMostListed`
/// entries, with `findings_in_all` beside them. Output that is no JSON object becomes `text`, an
/// array `list`.
ToolResult json_result(std::string_view output, int exit_code);

/// A command that failed: what its user sees, and the exit code.
ToolResult trouble_result(const std::string& line, int exit_code);

}  // namespace backbend::validate
