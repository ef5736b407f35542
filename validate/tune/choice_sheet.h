#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "validate/stage/stage.h"
#include "validate/tasks/progress.h"
#include "validate/tune/headroom_gauge.h"

namespace backbend::validate {

/// One column of the sheet.
struct SheetRig {
  std::string label;
  solver::SystemSpec spec;
};

/// The same poses under several rigs, a row for each pose, all framed alike: a PNG. Throws
/// Interrupted, render::RenderError.
std::vector<std::uint8_t> choice_sheet(const Stage& stage, const std::vector<SheetRig>& rigs,
                                       const std::vector<Direction>& poses, solver::Mapping mapping,
                                       Progress& progress);

}  // namespace backbend::validate
