#pragma once
#include <cstdint>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <string>
#include <vector>

#include "skin/character/character.h"
#include "skin/deform/linear_blend.h"
#include "solver/rig/spine_pose.h"
#include "validate/metrics/surface/bend_intent.h"
#include "validate/metrics/surface/spine_coordinate.h"

namespace backbend::validate {

/// The rest quantities of a mesh that every pose needs: made once, read by any number of threads.
///
/// Triangles lie in blocks of eight, to be measured side by side; those that stand on the spine
/// come first, slice by slice. A block that is not full repeats its last triangle. A slot is a
/// block's number times eight plus the lane. Corners are the vertices in the
/// order in which the blocks come to them, so that neighbours lie side by side.
///
/// Triangles inside of a part that moves as one rigid body come last, as do edges between two
/// triangles of one part: only the part's place changes, and with it what the part adds to the
/// volume.
struct MeshRest {
  static constexpr std::uint32_t kLanes = 8;
  struct Block {
    std::uint32_t corner[3][kLanes];
    float inverse[3][kLanes];      // of the upper triangular rest bases: 1/a, -b/(a c), 1/c
    std::uint32_t number[kLanes];  // the order of the character's triangles
    std::uint32_t present;         // bit i: lane i is a triangle of its own
    std::uint32_t upright;         // of those, bit i: it faces as it should at rest
    float normal[3][kLanes];       // of the triangles as bound
    std::uint32_t first_carrier, carriers;  // the joints that move them; none: not known
  };
  struct Carrier {
    float weight[3][kLanes];  // at the triangles' corners
    std::uint32_t joint;
  };
  struct Torso {              // of the blocks on the spine
    float offset[3][kLanes];  // of the triangles' middles from the spine line
    float s[kLanes];          // their arc fractions
    std::uint32_t slice;      // the nearest
  };
  struct EdgeBlock {                              // between two triangles each
    std::uint32_t first[kLanes], second[kLanes];  // slots
    float cosine[kLanes], sine[kLanes];           // of the angle between the two at rest
  };
  struct EdgeEnds {
    std::uint32_t a, b;    // corners along the edge, as the first triangle runs
    std::uint32_t number;  // in the order of the places that the edges join
  };
  std::vector<Block> block;
  std::vector<Carrier> carrier;
  std::vector<Torso> torso;           // of the first blocks
  std::vector<float> slot_area;       // at rest; 0 where a lane only repeats another
  std::vector<EdgeBlock> edge;        // the last may repeat its last edge
  std::vector<EdgeEnds> end;          // of every lane of every edge block
  std::vector<std::uint32_t> vertex;  // of each corner
  /// The triangles of one part that are left out where parts are rigid, in a closed mesh.
  struct Piece {
    double volume;          // of the tetrahedra over them with their tip in `tip`
    std::uint32_t tip;      // a corner of them
    std::size_t first_rim;  // its rim: the edges to the other triangles of its part
    std::size_t rim_count;
  };
  struct RimEdge {
    std::uint32_t a, b;  // corners, as the piece's triangle runs
  };
  std::vector<Piece> piece;
  std::vector<RimEdge> rim;
  // How many there are first that change where parts are rigid.
  std::size_t bending_blocks = 0, bending_edges = 0, bending_corners = 0;
  double area = 0.0, torso_area = 0.0, volume = 0.0;
  glm::dvec3 middle{0.0};
  std::string open_reason;     // empty: closed, and its volume has a meaning
  std::size_t triangles = 0;   // those with an area
  std::size_t degenerate = 0;  // triangles without area, left out
  std::size_t vertex_count = 0;
  std::size_t slice_count = 0;
  double slice_spacing = 0.0;  // arc fraction
};

/// How joints move a mesh: one entry of `bind_position` and `influences` per vertex.
struct MeshBinding {
  std::span<const glm::vec3> bind_position;
  std::span<const skin::Influences> influences;
  const skin::JointMatrices& rest;
};

/// `coordinate` per place, from spine_coordinate(); `slices` of the same mesh, one or more; `part`
/// per vertex, from RigidParts: empty where nothing is known of them; `binding`: null where the
/// mesh's joints are not known. Triangles without area are left out.
MeshRest prepare_mesh(const RestMesh& mesh, const SpineLine& line,
                      std::span<const float> coordinate, const SpineSlices& slices,
                      std::span<const int> part = {}, const MeshBinding* binding = nullptr);

/// What tells which way triangles should face in a pose.
///
/// A triangle should face with the sum of three unit vectors, one for each corner: where the joints
/// are known, what the corner's joints make of the triangle's own normal, whatever the shading;
/// where they are not, the corner's normal as skinned.
struct Facing {
  std::span<const glm::vec3> normal;  // as skinned, one per vertex
  std::span<const glm::mat3> joint;   // from face_turns(); empty: not known
};

/// What each joint makes of the normals of faces: the matrix of cofactors of what it makes of
/// points, but for a factor above 0.
std::vector<glm::mat3> face_turns(const skin::JointMatrices& joints);

/// Whether each part of RigidParts moved as one rigid body in a pose.
enum class Parts { rigid, unknown };

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

/// Measures one pose of the surface. `position` as skinned. Normals recomputed from the posed
/// triangles would always agree with them.
///
/// Strain amplification: the larger of stretch - 1 and 1 - squeeze of a triangle over what an ideal
/// beam bent and twisted as intended has at that place (at least 0.05, and the most within one bone
/// to either side), so that one limit serves every angle. `strain_most` is the figure to judge by:
/// the largest is that of one triangle, and grows as a mesh is refined. Only for triangles of the
/// torso between hips and chest. `intent` is for the slices that the mesh was prepared with;
/// `bone`: arc fraction of one bone. Of equal places the first in the character's order is named.
/// Where parts are rigid, the same is measured in less time, but for what rounding makes of
/// triangles that only moved.
///
/// Memory of the size of the posed mesh is kept for the calling thread's next pose.
MeshMeasures measure_mesh(const MeshRest& rest, std::span<const glm::vec3> position,
                          const Facing& facing, const BendIntent& intent, double bone,
                          Parts parts = Parts::unknown);

/// Strain amplification of every vertex, for heat maps: the largest of its triangles.
std::vector<float> strain_map(const MeshRest& rest, std::span<const glm::vec3> position,
                              const BendIntent& intent, double bone);

/// 1 at the vertices of triangles that do not face as they should and did at rest, else 0.
std::vector<float> inverted_map(const MeshRest& rest, std::span<const glm::vec3> position,
                                const Facing& facing);

/// How far apart two rigid motions take the vertices with `part` set: the largest distance, and
/// where. The lengths are those of the mesh.
struct PartDrift {
  double distance = 0.0;
  int vertex = -1;
};
PartDrift part_drift(std::span<const glm::vec3> rest_position, std::span<const std::uint8_t> part,
                     const solver::RigidMotion& moved, const solver::RigidMotion& carrier);

}  // namespace backbend::validate
