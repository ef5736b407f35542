#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "skin/character/character.h"
#include "solver/rig/spine_pose.h"
#include "solver/rig/spine_system.h"

namespace backbend::solver {  // solver/rig/box_solver.h
struct BoxMotion;
struct BoxPlaces;
}  // namespace backbend::solver

namespace backbend::skin {

/// What a user says about a skeleton: joint names, empty where nothing was said.
struct AnatomyHints {
  std::string hip, chest;
  std::vector<std::string> spine;
  std::vector<std::string> left_arm, right_arm;
  std::string rig_template;  // whose names the joints bear: skin/anatomy/rig_templates.h
  // `+Y`: which way the body stands, whatever is found.
  std::string up = "", forward = "";
  // What a person has confirmed: all that is doubtful, and what was then found; empty where that
  // was oblique.
  bool confirmed = false;
  std::string confirmed_up = "", confirmed_forward = "";
};

/// A joint that no driven joint carries although it touches one: it goes where that one goes.
struct Follower {
  int node = -1;    // the loose joint; what hangs from it comes along
  int leader = -1;  // a node of the spine, an arm, a leg or the tail, or below one
};

/// Where the spine, arms, head and legs are in a character, and how it stands.
///
/// Every index is into Character::nodes. `spine` runs from the hips to the head; its first
/// `chest_index` + 1 entries are the chain that a rig drives. That chain ends at the joint that the
/// arms hang from, as a chest control does: what it turns further up would leave the shoulder
/// blades behind. Neck and head go on from there with it.
struct Anatomy {
  std::vector<int> spine;
  std::size_t chest_index = 0;  // of `spine`: end of the driven chain, held by a chest control
  std::size_t neck_index = 0;   // of `spine`: the base of the neck; 0: not told, the chest
  int chest = -1;  // the joint that the arms hang from; -1: none. A fish is driven beyond it
  std::vector<int> left_arm, right_arm;  // clavicle outwards; empty where there are none
  std::vector<int> left_leg, right_leg;  // thigh (or what stands before it) downwards
  std::vector<int> tail;
  std::vector<int> other_figures;   // the uppermost node of each, which this spine does not move
  std::vector<Follower> followers;  // feet on IK roots, a jaw beside the head: see Follower
  int head = -1;
  glm::dvec3 up{0, 1, 0}, forward{0, 0, 1}, left{1, 0, 0};  // unit, world space
  glm::dvec3 found_up{0, 1, 0}, found_forward{0, 0, 1};     // the same without what hints specify
  double height = 0.0;                                      // rest extent along up, of this figure
  double spine_length = 0.0;         // rest arc length hips .. chest: the reference length
  std::vector<std::string> reasons;  // why this choice, one line each
  std::vector<std::string> doubts;   // what a person has to confirm before anything is judged
  bool sure() const { return doubts.empty(); }
};

/// Finds the anatomy from names, topology, weights and geometry together. Throws CharacterError
/// where no spine is found, or where the choice is unsure and hints are needed.
Anatomy find_anatomy(const Character& character, const AnatomyHints& hints = {});

/// Of each node whether it belongs to another figure in the file.
std::vector<bool> nodes_of_other_figures(const Character& character, const Anatomy& anatomy);

/// Body parts that mattes and per-region metrics speak of.
enum class Region : std::uint8_t {
  torso,
  head,
  arm_left,
  arm_right,
  leg_left,
  leg_right,
  tail,
  other
};
constexpr int kRegionCount = 8;
/// Stable lower-case name: `torso`, `arm_L`, ...
std::string_view region_name(Region region);
/// The region that each node moves.
std::vector<Region> node_regions(const Character& character, const Anatomy& anatomy);
/// The region of each vertex, from the joint with the largest weight.
std::vector<Region> vertex_regions(const Character& character, const Anatomy& anatomy);

/// How a solved spine moves a character's skeleton: built once per character and rig.
class SpineDriver {
 public:
  /// Keeps references to both.
  SpineDriver(const Character& character, const Anatomy& anatomy);
  SpineDriver(const Character&, Anatomy&&) = delete;

  /// The chain that is driven, hips .. chest, at rest in world space: what build_system() takes.
  const solver::RestChain& rest_chain() const { return chain_; }

  /// World matrices of every node in a pose. Each node goes rigidly with one of these:
  /// - the spine joints below the chest with the posed chain at their arc fraction of the rest
  ///   chain (place between two of the system's joints, turn by the shorter way between theirs);
  /// - the chest, neck and head with the chain's last joint;
  /// - hips, tail, and legs that start low on the spine with SpinePose::hip;
  /// - arms, forelegs and fins with the spine joint that they hang from (find_arm_attachment());
  ///   what the rig would have them follow, SpinePose::arms, is measured and not put on the mesh,
  ///   where it would tear the shoulders off the ribs;
  /// - everything else with its parent, and what hangs from none of these stays.
  /// The system's own rest pose gives the rest matrices exactly. A pose that brings its whole body
  /// (SpinePose::body) stands as that says.
  std::vector<glm::dmat4> drive(const solver::SpineSystem& system,
                                const solver::SpinePose& pose) const;

  /// The motions that drive() takes nodes along with, over a box of poses; node_motions() says
  /// which of them carries each node.
  std::vector<solver::BoxMotion> motions_over(const solver::SpineSystem& system,
                                              const solver::BoxPlaces& places) const;
  const std::vector<int>& node_motions() const { return motion_; }
  /// The joint of the chain that a motion of node_motions() is, 0 for the hips; -1: what stays.
  static int joint_of_motion(int motion);

  /// Where each spine joint hips .. chest stands along the rest chain, 0..1 by arc length.
  const std::vector<double>& joint_fractions() const { return joint_fraction_; }
  /// Whether the arms go rigidly with the end of the chain (false: none, or they hang lower on the
  /// spine): only then what a rig moves arms with can be told from what moves the chest.
  bool arms_follow_chest() const { return arms_follow_chest_; }
  /// Nodes that no motion of the spine reaches: helpers, props, the scene's root.
  std::vector<bool> static_nodes() const;

 private:
  void choose_motions();
  /// Where a pair of limbs starts, 0..1 along the chain.
  double start_fraction(const std::vector<int>& left, const std::vector<int>& right) const;

  const Character& character_;
  const Anatomy& anatomy_;
  solver::RestChain chain_;
  std::vector<double> joint_fraction_;  // of each driven spine joint, 0 hips .. 1 chest
  std::vector<int> motion_;             // of each node: which rigid motion carries it
  bool arms_follow_chest_ = false;
};

}  // namespace backbend::skin
