#pragma once
#include "cli/commands.h"

namespace backbend::cli {

// Commands that look at detectors and pictures themselves, what repairs a finding, and the rig to
// take instead.
void add_calibrate(const Registry& registry);
void add_diff(const Registry& registry);
void add_export(const Registry& registry);
void add_repair(const Registry& registry);

}  // namespace backbend::cli
