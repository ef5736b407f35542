#pragma once
#include "cli/commands.h"

namespace backbend::cli {

// Commands that look at detectors and pictures themselves, and what repairs a finding.
void add_calibrate(const Registry& registry);
void add_diff(const Registry& registry);
void add_repair(const Registry& registry);

}  // namespace backbend::cli
