#pragma once
#include <functional>

#include "skin/body/body_mesh.h"
#include "skin/body/body_shape.h"
#include "skin/character/character.h"

namespace backbend::skin {

/// Joint weights of a half body's vertices; the other half has the twins' weights. `joint` numbers
/// are of BodyDescription::joints. Sums are 1 to float accuracy, at most four weights a vertex.
///
/// Each vertex starts with the joints of the solid that owns it, changing from joint to joint along
/// that solid's chain over the stated length; heat then carries the weights over the surface of the
/// whole body for about BodySolid::soften metres. Heat runs on the skin and not through the air, so
/// nothing leaks from leg to leg or from arm to trunk.
///
/// `poll` is called between the steps, from any thread.
///
/// Source: I. Baran, J. Popovic, "Automatic Rigging and Animation of 3D Characters", 2007 (heat);
/// K. Crane et al., "Geodesics in Heat", 2013 (the implicit step on a triangle mesh).
std::vector<Influences> body_weights(const HalfMesh& mesh, const BodyShape& shape,
                                     const BodyDescription& description,
                                     const std::function<void()>& poll);

/// Weights of a subdivided half body, from those before: Loop's masks, so they stay smooth.
/// `coarse` is the mesh before, `edge_of` as subdivide() gave it.
std::vector<Influences> subdivide_weights(const HalfMesh& coarse,
                                          const std::vector<Influences>& weights,
                                          const std::vector<std::array<int, 2>>& edge_of,
                                          const BodyDescription& description);

/// The four largest weights of up to eight, without a step where the fifth overtakes the fourth:
/// what the fifth has is taken from all, and the rest scaled to sum 1.
Influences four_largest(const Influences& in);

}  // namespace backbend::skin
