#pragma once
#include <map>
#include <string>

namespace backbend::validate {

/// The program's version and the bill of materials of what it was built with, as a report's
/// provenance holds them: `backbend`, `compiler`, and `library NAME` for each library, with the
/// version of its package at build time and, where the library itself tells, the one that runs
/// now. Nothing of the machine but that.
std::map<std::string, std::string> program_versions();

}  // namespace backbend::validate
