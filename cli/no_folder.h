#pragma once
#include <filesystem>

#include "cli/commands.h"

namespace backbend::cli {

/// `-o -`: results go to standard output and nothing is written.
inline constexpr const char* kNoFolder = "-";

/// Prints a report, and gives its exit code. `page`: where its page is; empty: it has none.
int print_report(const validate::Report& report, const std::filesystem::path& page,
                 const Common& common);

}  // namespace backbend::cli
