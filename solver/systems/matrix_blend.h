#pragma once
#include <memory>

#include "solver/rig/spine_system.h"

namespace backbend::solver {

/// `matrix_blend`: fractions of a control's shortest turn, as a peer to compare with (an
/// emulation). Every fraction jumps as that turn passes half a circle.
///
/// `style = "rigify"`: RigifySpine, two half chains from the joint `pivot_pos`, on the drawn chain;
/// with `pivot_pos = 0` one chain from the hips whose bones each add one part of the turn from hip
/// to chest. `style = "mgear"`: joints at equal arc of a Bezier with handles of a third, X along
/// the tangent, up the side axis of that fraction of the turn from hip to chest. Facts: research
/// page on spines, S6.1 and S6.5.
std::unique_ptr<SpineSystem> build_matrix_blend(const SystemSpec& spec, const RestChain& chain);

}  // namespace backbend::solver
