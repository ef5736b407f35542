#pragma once
#include "skin/body/body_mesh.h"
#include "skin/body/body_shape.h"

namespace backbend::skin {

/// The surface of a shape on a cubic grid of edge `cell`, by marching tetrahedra: always a
/// manifold, with no ambiguous case. Only the shell that is found from `seed` outwards (a point
/// inside) is followed, so nothing is paid for empty space.
///
/// Throws CharacterError where `seed` is not inside.
/// Source: A. Doi, A. Koide, "An Efficient Method of Triangulating Equi-Valued Surfaces by Using
/// Tetrahedral Cells", 1991; each cube is cut into the six tetrahedra around one diagonal.
HalfMesh grid_surface(const BodyShape& shape, const glm::dvec3& seed, double cell);

}  // namespace backbend::skin
