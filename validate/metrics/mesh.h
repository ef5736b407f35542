#pragma once
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <string>
#include <vector>

#include "solver/spine_pose.h"
#include "validate/metrics/bend_intent.h"
#include "validate/metrics/spine_coordinate.h"

namespace backbend::validate {

/// What of a mesh at rest is needed for every pose: made once, read by any number of threads.
struct MeshRest {
  struct Triangle {
    std::uint32_t vertex[3];
    float inverse[3];  // of the upper triangular rest basis: 1/a, -b/(a c), 1/c
    float area;
    float s;               // arc fraction of its middle; NaN off the torso
    glm::vec3 offset;      // of its middle from the spine line
    std::uint32_t number;  // into the character's triangles
    bool inverted;         // faces against its normals already at rest
  };
  struct Edge {                   // between two triangles, vertices by place
    std::uint32_t a, b;           // along the edge, as the first triangle runs
    std::uint32_t first, second;  // into `triangle`
    float cosine, sine;           // of the angle between the two at rest
  };
  std::vector<Triangle> triangle;  // those with an area
  std::vector<Edge> edge;
  std::vector<std::uint32_t> vertex_of_place;  // some vertex at each place
  double area = 0.0, volume = 0.0;
  glm::dvec3 middle{0.0};
  std::string open_reason;     // empty: closed, and its volume has a meaning
  std::size_t degenerate = 0;  // triangles without area, left out
  std::size_t vertex_count = 0;
};

/// `coordinate` per place, from spine_coordinate(). Triangles without area are left out.
MeshRest prepare_mesh(const RestMesh& mesh, const SpineLine& line,
                      std::span<const float> coordinate);

/// Everything that is measured on the surface of one pose. NaN: not measured or without meaning.
struct MeshMeasures {
  std::size_t not_finite = 0;  // vertices; above 0 nothing else was measured

  double strain = 0.0;  // largest strain amplification over the torso; 1: an ideal bend
  int strain_vertex = -1;
  double strain_s = 0.0;     // arc fraction of the place
  double strain_most = 0.0;  // what 99.9 % of the torso's area stays below; NaN without a torso
  double stretch = 1.0;      // largest singular value of any triangle
  int stretch_vertex = -1;

  double inverted_area = 0.0;  // share of the rest area, beyond rest
  std::size_t inverted = 0;    // triangles
  int inverted_vertex = -1;

  double dihedral_deg = 0.0;  // largest change
  int dihedral_vertex = -1;

  double volume_change = 0.0;  // posed / rest - 1; NaN for an open mesh (MeshRest::open_reason)
};

/// Measures one pose of the surface. `position` and `normal` as skinned: normals recomputed from
/// the posed triangles would always agree with them.
///
/// Strain amplification: the larger of stretch - 1 and 1 - squeeze of a triangle over what an ideal
/// beam bent and twisted as intended has at that place (at least 0.05, and the most within one bone
/// to either side), so that one limit serves every angle. `strain_most` is the figure to judge by:
/// the largest is that of one triangle, and grows as a mesh is refined. Only for triangles of the
/// torso between hips and chest. `bone`: arc fraction of one bone.
MeshMeasures measure_mesh(const MeshRest& rest, std::span<const glm::vec3> position,
                          std::span<const glm::vec3> normal, const SpineSlices& slices,
                          const BendIntent& intent, double bone);

/// Strain amplification of every vertex, for heat maps: the largest of its triangles.
std::vector<float> strain_map(const MeshRest& rest, std::span<const glm::vec3> position,
                              const SpineSlices& slices, const BendIntent& intent, double bone);

/// How far vertices have moved against a rigid motion that should carry them: the largest distance
/// over those with `part` set, and where. The lengths are those of the mesh.
struct PartDrift {
  double distance = 0.0;
  int vertex = -1;
};
PartDrift part_drift(std::span<const glm::vec3> rest_position, std::span<const glm::vec3> position,
                     std::span<const std::uint8_t> part, const solver::RigidMotion& carrier);

}  // namespace backbend::validate
