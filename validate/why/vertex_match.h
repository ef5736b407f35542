#pragma once
#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

namespace backbend::validate {

/// A surface at rest, world space. Both arrays outlive what is made of them.
struct RestSurface {
  const std::vector<glm::vec3>& position;
  const std::vector<glm::uvec3>& triangles;
};

/// Which vertices of two surfaces correspond, by number.
struct VertexMatch {
  std::vector<std::uint32_t> before_of_after, after_of_before;
  // Each vertex has a partner of its own, and each triangle, too: the same mesh in another order,
  // however far its vertices were moved.
  bool same_mesh = false;
  double coverage = 0.0;  // share of either's vertices that have a partner, the smaller of the two
};

/// Units of the positions.
struct MatchReach {
  double near = 0.0;            // as far a closest rest point counts as a partner
  double exact = 0.0;           // as far two vertices are at one place
  double least_coverage = 0.0;  // share; below it no numbers are given
};

/// Vertices that alone are at one place in both surfaces correspond; from those on the triangles
/// tell: of two triangles that share two corners in the same order the third corners correspond.
/// Where that does not pair every vertex with its own (an export merged or split vertices), copies
/// of a place count as one, and a vertex's partner is at the same corner of the same triangle. What
/// the triangles do not reach corresponds to the closest rest point of the other, and has a partner
/// where that is within `near`.
VertexMatch match_vertices(const RestSurface& before, const RestSurface& after,
                           const MatchReach& reach);

}  // namespace backbend::validate
