#pragma once
#include <memory>

#include "solver/rig/spine_system.h"

namespace backbend::solver {

/// `stretchy`: a chain on one cubic Bezier whose length blends between the rest length and the
/// curve's, ratio = ((L - L0) s + L0) / L0. `form = "bones"` scales the bones and walks them along
/// the curve; `form = "carve"` cuts the curve and resamples it.
///
/// Drawn as `chain.curve` (four CVs), its controls are the CVs; drawn as joints, a hip and a chest
/// control place them (0.4 of the rest length out, as in `isner`).
/// Source: the seed's two posts on the stretchy spine (R67-R87); wishes W7, W8, W13, W15.
std::unique_ptr<SpineSystem> build_stretchy(const SystemSpec& spec, const RestChain& chain);

}  // namespace backbend::solver
