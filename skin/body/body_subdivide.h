#pragma once
#include <array>
#include <vector>

#include "skin/body/body_mesh.h"
#include "skin/body/body_shape.h"

namespace backbend::skin {

/// Cuts every triangle in four and moves the new vertices onto the surface. `edge_of[i]` are the
/// two vertices between which new vertex `i` (counted from the old number of vertices) stands.
void subdivide(HalfMesh& mesh, const BodyShape& shape, std::vector<std::array<int, 2>>& edge_of);

/// Evens out the few triangles that a subdivision left thin or turned over, by moving their
/// vertices to the middle of their neighbours on the surface. The rest stays as it is.
void mend(HalfMesh& mesh, const BodyShape& shape);

}  // namespace backbend::skin
