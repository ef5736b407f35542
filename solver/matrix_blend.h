#pragma once
#include <memory>

#include "solver/spine_system.h"

namespace backbend::solver {

/// `matrix_blend`: fractions of the shortest turn from hip to chest, as a peer to compare with (an
/// emulation). Every fraction jumps as that turn passes half a circle.
///
/// `style = "rigify"`: a chain from the hips whose bones each add one part of the turn (copied
/// local transforms at influence 1/count). `style = "mgear"`: joints at equal arc of a Bezier with
/// handles of a third, X along the tangent, the blend's side axis as up vector. Facts: research
/// page on spines, S6.1 and S6.5.
std::unique_ptr<SpineSystem> build_matrix_blend(const SystemSpec& spec, const RestChain& chain);

}  // namespace backbend::solver
