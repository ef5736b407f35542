#pragma once
#include <memory>

#include "solver/rig/spine_system.h"

namespace backbend::solver {

/// `spline_ik`: the spline IK of today's packages, as a peer to compare with (an emulation): bones
/// on a Bezier between hip and chest, or on `resolution_u` straight pieces of it as Blender draws
/// them.
///
/// `y_scale_mode = "fit_curve"`: joints at equal steps of the curve's length, the bones as long as
/// that makes them (the default of Blender's constraint). `"none"`: bones of fixed length march
/// along it, each joint where a sphere of the bone's length about the one before meets the curve.
///
/// `twist = "fk_roll"`: each bone keeps the roll that it has from its parent (Blender's
/// constraint). `twist = "spread"`: the twist left between the last bone and chest, as a value
/// within half a turn, is spread evenly (Maya's advanced twist, with its bones' fixed lengths); it
/// jumps as that value passes half a turn. Facts: research page on spines, S6.3 and S6.6.
std::unique_ptr<SpineSystem> build_spline_ik(const SystemSpec& spec, const RestChain& chain);

}  // namespace backbend::solver
