#pragma once
#include <memory>

#include "solver/rig/spine_system.h"

namespace backbend::solver {

/// `curve`: the thesis's rig. Three rotation-only controls pose three bones; five points riding on
/// them draw a curve; a chain of `bones` follows the curve and takes Top's roll.
///
/// Options (default first): `basis` = bspline | interpolate | linear; `knots` = chord | uniform |
/// centripetal (of interpolate, frozen at rest); `bones` = 10, 1 to 64; `follow` = chase |
/// on_curve; `length` = nulls | rest | null_sum | arc | close; `roll` = top | full; `arms` =
/// effector | top. Spec 4.2; R3 .. R66 of research/seeds.md.
///
/// A rest chain of other than four joints is cut at thirds of its arc; the chain built at rest is
/// the system's own rest, on its curve.
std::unique_ptr<SpineSystem> build_curve_spine(const SystemSpec& spec, const RestChain& chain);

}  // namespace backbend::solver
