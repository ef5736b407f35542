#pragma once
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "validate/model/report.h"

namespace backbend::battery {

/// What `backbend check` says of a file, without pictures.
struct Outcome {
  int exit_code = 0;
  std::string refused;                     // why the file was not taken; empty: it was
  std::vector<validate::Finding> failing;  // worst first
  std::vector<std::string> reasons;        // why the verdict is what it is
  std::map<std::string, double> worst;     // of each metric, by its name in the report
};

/// `backbend check FILE --quick`, in this process.
Outcome check_character(const std::filesystem::path& file);
/// `backbend check [FILE] --baked CLIP`; `character` empty: the clip's own body.
Outcome check_clip(const std::filesystem::path& character, const std::filesystem::path& clip);

}  // namespace backbend::battery
