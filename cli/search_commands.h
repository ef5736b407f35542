#pragma once
#include "cli/commands.h"

namespace backbend::cli {

// Commands that search: for the worst pose of a rig.
void add_hunt(const Registry& registry);

}  // namespace backbend::cli
