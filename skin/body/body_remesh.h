#pragma once
#include <functional>

#include "skin/body/body_edge_sizes.h"
#include "skin/body/body_mesh.h"
#include "skin/body/body_shape.h"

namespace backbend::skin {

/// Remeshes a half body to even triangles of the wanted edge lengths, on the surface, without
/// changing its topology: splits, collapses, flips and relaxes in turn, one operation after
/// another.
///
/// Source: M. Botsch, L. Kobbelt, "A Remeshing Approach to Multiresolution Modeling", 2004; sizes
/// after curvature as in M. Dunyach et al., "Adaptive Remeshing for Real-Time Mesh Deformation",
/// 2013. `poll` is called between the steps. Vertices on x = 0 stay there, and no edge but those of
/// the border joins two of them, so the mirrored whole is a manifold.
void remesh(HalfMesh& mesh, const BodyShape& shape, const EdgeSizes& sizes, int rounds,
            const std::function<void()>& poll);

}  // namespace backbend::skin
