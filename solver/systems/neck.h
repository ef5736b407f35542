#pragma once
#include <memory>

#include "solver/rig/spine_system.h"

namespace backbend::solver {

/// `neck`: one controller for a whole neck. Every driven vertebra turns about its parent's pivot
/// and axes by its share of the controls (base Y, top Y, then Z); a roll about its own X axis is
/// laid on last and moves no pivot.
///
/// Built on the vertebrae of a rest file (`chain.frame`: head first, fixed parent last, the order
/// of the output) or on drawn joints (the first is the fixed parent; local X points back to it,
/// local Y to the right). Source: the seed's system controller (R88-R122, ambiguities A21-A26).
std::unique_ptr<SpineSystem> build_neck(const SystemSpec& spec, const RestChain& chain);

}  // namespace backbend::solver
