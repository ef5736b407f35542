#pragma once
#include <string>
#include <vector>

#include "solver/rig/spine_system.h"

namespace backbend::solver {

/// The steps by which a system goes from its controls to its joints, one line each, in order, as
/// its options have them. Every step uses the controls and the steps before it, nothing else.
std::vector<std::string> evaluation_order(const SpineSystem& system);

}  // namespace backbend::solver
