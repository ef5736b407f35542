#pragma once
#include "cli/commands.h"

namespace backbend::cli {

// Commands that search: for the worst pose of a rig, for what made a finding, for better options.
void add_hunt(const Registry& registry);
void add_why(const Registry& registry);
void add_tune(const Registry& registry);

}  // namespace backbend::cli
