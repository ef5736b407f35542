#pragma once
#include <memory>

#include "solver/rig/spine_system.h"

namespace backbend::solver {

/// `even`: the three traditional rotation controls without their faults. The frame at arc fraction
/// s is the forward-kinematics product with every Euler channel scaled by a smooth weight, and the
/// joints are the integral of the rest tangent turned by it. No pose is singular; no frame turns
/// faster than a channel does; the chest carries exactly the top control's turn.
///
/// Derivation, proofs and bounds: docs/even.md.
std::unique_ptr<SpineSystem> build_even(const SystemSpec& spec, const RestChain& chain);

}  // namespace backbend::solver
