#pragma once
#include <memory>

#include "solver/spine_system.h"

namespace backbend::solver {

/// `spline_ik`: the spline IK of today's packages, as a peer to compare with (an emulation). Bones
/// of fixed length march along a Bezier between hip and chest: each joint where a sphere of the
/// bone's length about the one before meets the curve.
///
/// `twist = "fk_roll"`: each bone keeps the roll that it has from its parent (Blender's
/// constraint). `twist = "spread"`: the twist left between the last bone and chest, as a value
/// within half a turn, is spread evenly (Maya's advanced twist); it jumps as that value passes half
/// a turn. Facts: research page on spines, S6.3 and S6.6.
std::unique_ptr<SpineSystem> build_spline_ik(const SystemSpec& spec, const RestChain& chain);

}  // namespace backbend::solver
