#pragma once
#include <memory>

#include "solver/rig/spine_system.h"

namespace backbend::solver {

/// `isner`: an emulation of the quaternion spine of the Softimage default biped. Hip and chest
/// (rotation and translation), hip depth and chest depth place the four points of one cubic Bezier;
/// vertebrae sit on it by arc length and take their up vector from the slerp of hip and chest.
///
/// Options (default first): `vertebrae` = 5, 1 to 64; `placement` = interior | inclusive;
/// `depth` = [0.4, 0.4], fractions of the rest length; `length` = fixed | stretchy; `aim` = project
/// | shortest_arc | none; `slerp` = shortest | raw.
///
/// Joints: the vertebrae from the hip up, then (interior) the top vertebra, which carries the
/// arms. The rest axis runs straight from the chain's first joint to its last.
///
/// It is an emulation: the operator that holds the real rig's length was never published, and which
/// way its slerp goes is inferred (research/spine.md 1). Spec 4.3; R11 .. R19 of research/seeds.md.
std::unique_ptr<SpineSystem> build_isner(const SystemSpec& spec, const RestChain& chain);

}  // namespace backbend::solver
