#pragma once
#include <cstddef>
#include <glm/gtc/quaternion.hpp>
#include <glm/vec3.hpp>
#include <vector>

#include "solver/curves/bent_chain.h"
#include "solver/curves/curve.h"
#include "solver/math/box_number.h"
#include "solver/rig/spine_pose.h"

namespace backbend::solver {

/// The deform bones of Rigify's spine (`spines.basic_spine`): two half chains that start at a pivot
/// joint, one down to the hips and one up to the chest. Neither control reaches the other's half.
///
/// Each joint of a half chain of n copies the local transform of its control at influence 1/n, so
/// joint j of the upper half, counted from the pivot, is turned by the (j + 1)/n-th part of chest's
/// turn and moved, in the frame of the joint before it, by 1/n of chest's move; the lower half the
/// same from the hips. The pivot itself stands half-way between what the first joint of either half
/// makes of it. A deform bone has the turn of the joint at its foot, swung by the shortest arc
/// until it points to the next: in the lower half that is the joint beyond it, at the pivot the
/// half-way one. Found by posing rigs that Blender 3.4.1 generated (tests/cli/blender_poses.py).
class RigifySpine {
 public:
  /// What a control does to its half: a turn from rest, and a move in rig space.
  template <class Math>
  struct ControlOf {
    typename Math::Turn turn{glm::dquat(1.0, 0.0, 0.0, 0.0)};
    typename Math::Vector move{0.0, 0.0, 0.0};
  };
  using Control = ControlOf<PoseMath>;

  /// `rest`: the joints at rest, hips first, the last the chest's end. `pivot`: Rigify's
  /// `pivot_pos`, the number of bones below the pivot, 1 .. bones - 1. `side`: unit, where a bone
  /// that must double back turns about (in the frame of the joint at its foot).
  RigifySpine(std::vector<glm::dvec3> rest, std::size_t pivot, const glm::dvec3& side);

  /// Writes position, turn and flip_margin of every joint; the last carries the last bone's turn. A
  /// margin is the least of: what chest's and hips' turns lack to half a turn, where the joint
  /// takes a fraction of it; what the two lack at the pivot; what a bone's swing lacks.
  void lay(const Control& hips, const Control& chest, SpinePose& pose) const;

  /// Every joint's place and turn over a box of poses.
  void lay(const ControlOf<BoxMath>& hips, const ControlOf<BoxMath>& chest,
           std::vector<BoxVector>& position, std::vector<BoxTurn>& turn) const;

  /// The chain without its corners: every joint's part of the turn is spread from the middle of the
  /// bone before it to that of the bone after it. `count` points at equal steps of the rest's
  /// length.
  std::vector<glm::dvec3> fine_chain(const Control& hips, const Control& chest,
                                     std::size_t count) const;

  /// The chain and fine_chain() of `count` points over a box of poses at which only the chest
  /// turns.
  BentChain bent(const BoxTurn& chest, std::size_t count) const;

 private:
  template <class Math>
  struct Joints {
    std::vector<typename Math::Vector>& position;
    std::vector<typename Math::Turn>& turn;
    typename Math::Turn above_turn{glm::dquat(1.0, 0.0, 0.0, 0.0)};  // of the first joints
    typename Math::Turn below_turn{glm::dquat(1.0, 0.0, 0.0, 0.0)};  // of both halves
  };
  template <class Math>
  void lay_joints(const ControlOf<Math>& hips, const ControlOf<Math>& chest,
                  Joints<Math>& joints) const;
  void lay_margins(const Control& hips, const Control& chest, const Joints<PoseMath>& joints,
                   std::vector<double>& margin) const;
  void swing_to_next(std::size_t bone, SpinePose& pose) const;
  /// Whether the joint at bone k's foot has the turn of the bone itself. Both ends of the outermost
  /// bones hang from one joint; so does all above the pivot while nothing moves it.
  bool is_rigid(std::size_t k, bool chest_moves) const;
  /// What the fine chain has of a control's turn at an arc fraction.
  struct Shares {
    double of_hips, of_chest;
  };
  Shares fine_shares(double fraction) const;
  glm::dquat fine_turn(const Control& hips, const Control& chest, double fraction) const;

  std::vector<glm::dvec3> rest_;
  std::size_t pivot_;
  glm::dvec3 side_;
  Curve path_;  // through rest_
  double pivot_fraction_;
  std::vector<double> middle_;  // arc fraction of each bone's
};

}  // namespace backbend::solver
