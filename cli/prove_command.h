#pragma once
#include "cli/commands.h"

namespace backbend::cli {

void add_prove(const Registry& registry);

}  // namespace backbend::cli
