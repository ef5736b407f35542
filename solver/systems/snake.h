#pragma once
#include <memory>
#include <vector>

#include "solver/curves/path_frames.h"
#include "solver/rig/spine_system.h"

namespace backbend::solver {

/// `snake`: a body that one channel slides along a path. Controls ride the path at equal arc steps,
/// swing sideways by a sine of their place (the slither) and are the CVs of the body curve; a chain
/// of the rest's bones is walked along it (spline IK), and the joints ride a ribbon on the same
/// curve, between the walked places and their rest parameters (`stretchy`).
///
/// `chain.path` is the path. On a character's chain the path is its joints, continued straight on.
/// Source: the seed's hybrid rig (R123-R154, ambiguities A27-A38; wish W14).
std::unique_ptr<SpineSystem> build_snake(const SystemSpec& spec, const RestChain& chain);

/// Where the controls of such a body are at rest, tail to head, and their frames. Throws as
/// build_system() does.
std::vector<PathFrames::Place> snake_at_rest(const SystemSpec& spec, const RestChain& chain);

}  // namespace backbend::solver
