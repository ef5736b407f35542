#pragma once
#include "cli/commands.h"

namespace backbend::cli {

// Commands that look at detectors and pictures themselves.
void add_calibrate(const Registry& registry);
void add_diff(const Registry& registry);

}  // namespace backbend::cli
