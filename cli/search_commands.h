#pragma once
#include "cli/commands.h"

namespace backbend::cli {

// Commands that search: for the worst pose of a rig, for what made a finding.
void add_hunt(const Registry& registry);
void add_why(const Registry& registry);

}  // namespace backbend::cli
