#pragma once
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "skin/anatomy/anatomy.h"
#include "skin/character/character.h"
#include "skin/deform/skinning.h"
#include "solver/rig/spine_system.h"
#include "validate/metrics/chain/chain.h"
#include "validate/metrics/surface/mesh.h"
#include "validate/metrics/surface/rigid_parts.h"
#include "validate/metrics/surface/self_intersection.h"
#include "validate/metrics/surface/slice_metrics.h"

namespace backbend::validate {

/// Everything geometric that is measured on one pose of one rig on one character.
struct BodyMeasures {
  ChainMeasures chain;
  SliceMeasures slices;
  SlicePose slice_pose;  // where the slices are; empty where nothing was measured
  MeshMeasures surface;
  double arm_drift = 0.0;  // how far what the rig moves arms with would take the arms' vertices
                           // from where the chest control takes them, share of the height; NaN
                           // where the character has no arms that the chest carries
  int arm_drift_vertex = -1;
  double crossing = 0.0;  // share of the surface whose triangles run through others and did not at
                          // rest; NaN where it was left out or nothing was measured
  int crossing_vertex = -1;
};

/// Whether measure() looks for triangles that run through others, which costs a third of it and
/// more; left out, BodyMeasures::crossing stays NaN.
enum class Crossing { measured, left_out };

/// Whether a posed mesh is what linear blending makes of its joints, or a rig's deformers add to
/// it.
enum class Deformers { none, added };

/// A rig's curves at rest: made once per rig and character.
struct RigAtRest {
  const solver::SpineSystem* system;
  std::vector<glm::dvec3> curve;  // intended, kCurvePoints points
  int bones;
};
constexpr std::size_t kCurvePoints = 257;
RigAtRest rig_at_rest(const solver::SpineSystem& system);
/// The length that a pose asks of the chain, of rest: 1, or that of the intended curve where the
/// pose stretches, which is what the rig's options make of the request.
double asked_length(const RigAtRest& rig, std::span<const glm::dvec3> intended, bool stretches);

/// What a character's surface allows to be told.
struct SurfaceScope {
  bool has_volume = false;
  bool has_kinks = false;  // and twist jumps
  bool has_folds = false;
};

/// A character prepared for measuring: slices, topology and masks, made once, read by any number of
/// threads.
class BodyMetrics {
 public:
  static constexpr int kSliceCount = 64;
  /// Keeps what it needs; the arguments may go away.
  BodyMetrics(const skin::Character& character, const skin::Anatomy& anatomy,
              const skin::SpineDriver& driver);

  /// Measures one pose. `pose` is the solved chain for `control`, `mesh` the character skinned with
  /// it; `twist` (radians) is what the body pose asks for between hips and chest, `stretches`
  /// whether it asks for another length. `world_from_node`: the nodes that move the mesh with the
  /// character's own weights; empty where they are not known. They tell how triangles should face,
  /// and without deformers save work where parts move as one body. Where the chain is not finite,
  /// or a vertex is not, the rest stays unmeasured (NaN, and the counts say so).
  BodyMeasures measure(const RigAtRest& rig, std::span<const double> control,
                       const solver::SpinePose& pose, const skin::PosedMesh& mesh, double twist,
                       bool stretches = false, Crossing crossing = Crossing::measured,
                       std::span<const glm::dmat4> world_from_node = {},
                       Deformers deformers = Deformers::none) const;

  /// A part of measure() that costs much, alone. With Parts::unknown triangles of one part are
  /// tried against each other, too: a studio's own rig may bring an arm into the head.
  SelfIntersection::Measures self_intersection(std::span<const glm::vec3> position,
                                               Parts parts = Parts::rigid) const;
  /// Values per vertex for heat maps of the same pose.
  std::vector<float> strain_heat(const RigAtRest& rig, std::span<const double> control,
                                 const solver::SpinePose& pose, const skin::PosedMesh& mesh,
                                 double twist, bool stretches = false) const;
  /// 1 at the vertices of triangles that are turned over, else 0. `world_from_node` as above.
  std::vector<float> inverted_heat(const skin::PosedMesh& mesh,
                                   std::span<const glm::dmat4> world_from_node) const;

  const SpineSlices& slices() const { return slices_; }
  SurfaceScope scope() const;
  /// Why something cannot be told of this surface, a sentence each.
  std::vector<std::string> why_not() const;
  const SlicePose& rest_slices() const { return rest_slices_; }
  const MeshRest& mesh() const { return mesh_; }
  double height() const { return height_; }
  /// Slices that one turning spans, the same for every rig so that rigs can be compared: one of the
  /// character's own spine bones, over which linear blending repeats itself.
  int window() const { return window_; }
  /// Where each vertex stands along the spine, 0 hips .. 1 chest; NaN off the torso.
  const std::vector<float>& coordinate() const { return coordinate_; }
  /// The vertices where they stand at rest, world space.
  const std::vector<glm::vec3>& rest_position() const { return rest_position_; }
  /// Names of the driven spine joints, hips first, and where they stand along the spine.
  const std::vector<std::string>& spine_names() const { return spine_name_; }
  const std::vector<double>& spine_fractions() const { return spine_fraction_; }

 private:
  BendIntent intent(const RigAtRest& rig, const std::vector<glm::dvec3>& curve,
                    const solver::SpinePose& pose, double twist, bool stretches) const;
  std::vector<glm::mat3> face_turns_of(std::span<const glm::dmat4> world_from_node) const;

  double height_ = 0.0;
  int window_ = 2;
  std::vector<std::string> spine_name_;
  std::vector<double> spine_fraction_;
  std::vector<skin::SkinJoint> joints_;
  std::vector<glm::vec3> rest_position_;
  std::vector<float> coordinate_;  // of each vertex
  std::vector<std::uint8_t> arm_;  // vertices that an arm moves entirely
  bool has_arms_ = false;
  SpineSlices slices_;
  SlicePose rest_slices_;
  MeshRest mesh_;
  RigidParts parts_;
  std::optional<SelfIntersection> crossing_;
  struct Loose {  // the same without parts: made where a pose asks for it
    std::once_flag made;
    std::optional<SelfIntersection> crossing;
  };
  std::unique_ptr<Loose> loose_ = std::make_unique<Loose>();
};

/// How much worse a rig's mesh is than the ideal bend's in the same pose. Above 0: worse.
struct MeshExcess {
  double kink_deg = 0.0;  // the largest kink that the pair of them differs by
  int kink_slice = -1;
  double twist_jump_deg = 0.0;
  double area_loss = 0.0;  // largest loss of slice area beyond the ideal's, share
  int area_slice = -1;
  double strain = 0.0, inverted_area = 0.0, folded = 0.0, dihedral_deg = 0.0;
};
/// `window`: BodyMetrics::window() of the character.
MeshExcess mesh_excess(const BodyMeasures& rig, const BodyMeasures& ideal, int window);

}  // namespace backbend::validate
