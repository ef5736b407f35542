#pragma once
#include <vector>

#include "skin/body/body.h"
#include "skin/body/body_mesh.h"

namespace backbend::skin {

/// The half of a body that is mirrored to the whole (all of it where the description is not
/// symmetric): one entry of each per vertex.
struct SkinnedHalf {
  HalfMesh mesh;
  std::vector<glm::dvec3> normal;   // unit
  std::vector<Influences> weights;  // joints of the description, four at most
};

/// Finds the surface, makes it even, weighs it. Throws as make_body() says.
SkinnedHalf build_half(const BodyDescription& description, const BodyOptions& options);

}  // namespace backbend::skin
