#pragma once
#include "cli/commands.h"

namespace backbend::cli {

void add_serve(const Registry& registry);

}  // namespace backbend::cli
