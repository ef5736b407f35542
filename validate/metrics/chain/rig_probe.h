#pragma once
#include <functional>
#include <vector>

#include "solver/rig/spine_system.h"
#include "validate/metrics/chain/flip.h"

namespace backbend::validate {

/// Channel values at t, 0..1 over a sweep.
using ControlPath = std::function<std::vector<double>(double t)>;

/// A spine system along a path of its controls, as the flip detector takes it: joint turns,
/// positions, bone directions and flip margins. `system` must outlive the result.
FlipRig probe(const solver::SpineSystem& system, ControlPath path);

/// Tells a system which poses every search along a path of so many intervals begins with: their
/// ends, halves and quarters (SpineSystem::prepare()).
void prepare_search(const solver::SpineSystem& system, const ControlPath& path, int intervals);

/// Settings that fit a system: its arc fractions and rest length.
FlipSettings flip_settings(const solver::SpineSystem& system, int intervals, double control_deg);

/// A straight path between two body poses under a mapping.
ControlPath straight_path(const solver::SpineSystem& system, const solver::BodyPose& from,
                          const solver::BodyPose& to, solver::Mapping mapping);

}  // namespace backbend::validate
