#pragma once
#include <map>
#include <string>
#include <vector>

#include "skin/anatomy/anatomy.h"
#include "skin/clip/clip.h"
#include "skin/deform/skinning_plan.h"
#include "validate/metrics/math/rotation.h"

namespace backbend::validate {

/// Names of clip joints that stand for joints of the character under another name.
using JointMap = std::map<std::string, std::string>;  // by the character's joint

/// The clip's skeleton as a character without a body; Node::file_node is the clip's joint. Throws
/// CharacterError where it has none that can stand.
skin::Character bare_skeleton(const skin::Clip& clip);

/// How a clip's motion reached the character.
enum class ClipFit {
  same,      // the clip's own skeleton, or one that stands as it does: its motion as it is
  retarget,  // another skeleton: turns joint by joint, on the character's own bones
  points     // no joints: the rigid motion that fits each joint's vertices best
};

/// A clip laid onto a character, frame by frame. The hips are held where they stand at rest: a
/// body's travel is no motion of its spine.
class ClipBody {
 public:
  /// Throws CharacterError where a spine joint has none in the clip (naming the nearest), or the
  /// points are not those of the character. `character` and `anatomy` must outlive this; a
  /// character without vertices is only a skeleton.
  ClipBody(const skin::Character& character, const skin::Anatomy& anatomy, const skin::Clip& clip,
           const JointMap& names);

  std::size_t frame_count() const { return frames_; }
  ClipFit fit() const { return fit_; }
  /// World matrices of every node of the character.
  const std::vector<glm::dmat4>& world_from_node(std::size_t frame) const { return world_[frame]; }
  /// Rotation of a node from rest, in the hips' frame; not finite where the clip collapses it.
  glm::dquat turn(std::size_t frame, int node) const;
  /// Rotation of the hips from rest, in the world, before they were held.
  const glm::dquat& hips_turn(std::size_t frame) const { return hips_turn_[frame]; }
  /// Whether the clip says where the vertices are, so that no skinning is needed.
  bool has_points() const { return !point_.empty(); }
  /// The body as the clip has it: its own points, or linear blending of its joints.
  skin::PosedMesh mesh(std::size_t frame) const;
  /// Linear blending whatever the clip has.
  skin::PosedMesh blended(const std::vector<glm::dmat4>& world_from_node) const;
  /// Distances of linear blending from the clip's points over all frames and vertices: the 99th
  /// percentile, in the character's unit. NaN without both.
  double blending_error() const;
  /// How joints and points were matched, for a person.
  const std::vector<std::string>& notes() const { return notes_; }

 private:
  void match_joints(const skin::Clip& clip, const JointMap& names);
  bool is_same_file(const skin::Clip& clip) const;
  void match_by_place(const skin::Clip& clip);
  void check_spine(const skin::Clip& clip) const;
  void follow(const skin::Clip& clip);
  void retarget(const skin::Clip& clip);
  void match_points(const skin::Clip& clip);
  void fit_joints();
  void hold_hips();
  double rest_distance(const skin::Clip& clip, double unit) const;
  double spine_ratio(const skin::Clip& clip) const;

  const skin::Character& character_;
  const skin::Anatomy& anatomy_;
  skin::SkinningPlan plan_;
  skin::PosedMesh rest_;
  std::size_t frames_ = 0;
  ClipFit fit_ = ClipFit::same;
  double unit_ = 1.0;            // the clip's in the character's
  std::vector<int> clip_joint_;  // of each node, -1 for none
  // Of a spine matched by place to one of another number of joints: between which two of the
  // clip's joints a node turns, and how far from the first to the second.
  struct Between {
    int below = -1, above = -1;
    double share = 0.0;
  };
  std::map<int, Between> between_;  // by node
  std::vector<std::vector<glm::dmat4>> world_;
  std::vector<glm::dquat> hips_turn_;
  std::vector<glm::vec3> point_;  // [frames x vertices]
  std::vector<std::string> notes_;
};

/// The same anatomy, its chain taken on to the base of the neck: a clip moves the joint that the
/// arms hang from as it moves those below it, and where that one bends is seen by the next.
skin::Anatomy up_to_the_neck(const skin::Character& character, skin::Anatomy anatomy);

}  // namespace backbend::validate
