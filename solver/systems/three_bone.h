#pragma once
#include <memory>

#include "solver/rig/spine_system.h"

namespace backbend::solver {

/// `three_bone`: the baseline. Lower carries Middle carries Top, rotations only; four joints.
/// Source: the traditional FK spine that the thesis of spec 4.1 starts from (R1, R2).
std::unique_ptr<SpineSystem> build_three_bone(const SystemSpec& spec, const RestChain& chain);

}  // namespace backbend::solver
