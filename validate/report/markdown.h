#pragma once
#include <cstddef>
#include <string>

#include "validate/model/report.h"

namespace backbend::validate {

/// The longest comment GitHub takes, in characters; kept in bytes, which is never more.
inline constexpr std::size_t kCommentLimit = 65536;

/// The report as GitHub-flavoured Markdown for a pull-request comment: verdict, headroom, findings,
/// canaries, what was not measured, next commands. Never longer than `limit` bytes: rows that do
/// not fit are left out and their number is said. Every name stands in a code span, so none can
/// mention a person, close an issue or carry markup.
std::string markdown_summary(const Report& report, std::size_t limit = kCommentLimit);

}  // namespace backbend::validate
