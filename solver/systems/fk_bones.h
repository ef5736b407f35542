#pragma once
#include <array>
#include <glm/gtc/quaternion.hpp>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <span>

#include "solver/math/box_number.h"
#include "solver/math/lane_vectors.h"
#include "solver/math/rotation.h"
#include "solver/rig/box_solver.h"
#include "solver/rig/spine_system.h"

namespace backbend::solver {

/// The three bones of the traditional spine under their zero nulls: Lower carries Middle carries
/// Top; each control turns its bone about the bone's own start, in its own rest frame.
///
/// Everything is in rig space. Controls ride on the joints: bone k's control stands at joint[k].
struct FkBones {
  struct Pose {
    std::array<glm::dvec3, 4> joint;  // the last is the tip
    std::array<glm::dquat, 3> frame;  // of bone and control: X along the bone
    std::array<glm::dquat, 3> turn;   // from rest
  };

  /// The bones of a chain (cut at thirds of its arc unless it has four joints). Throws RigError for
  /// a chain that check_chain() refuses.
  FkBones(const RestChain& chain, const std::string& system);

  /// `control` holds lower, middle, top x (RX, RY, RZ), radians. All zero is `rest` to the last
  /// bit.
  Pose pose(std::span<const double> control) const;

  /// Four poses side by side, each bit for bit pose() of its own.
  struct PoseLanes {
    std::array<LaneVector, 4> joint;
    std::array<LaneTurn, 3> turn;
  };
  /// Bit i of `good`: lane i holds. Others have every channel at 0 or one past the reach of the
  /// fast sines.
  PoseLanes pose(const std::array<Lanes, 9>& control, int& good) const;

  /// The bones over a box of poses.
  struct BoxPose {
    std::array<BoxVector, 4> joint;
    std::array<BoxVector, 3> bone;  // from joint to joint
    std::array<BoxTurn, 3> turn;
  };
  BoxPose pose(std::span<const BoxReal> control) const;
  /// The same seen from the middle bone, which does not move then, and the others hardly. Lower's
  /// control has to be at rest.
  BoxPose pose_from_middle(std::span<const BoxReal> control) const;

  /// What a body pose sets on a hip and a chest control with moves, over a box: the chest's three
  /// turns, and for spread its three moves, to where the tip would be.
  void set_chest(const BodyBox& body, Mapping mapping, std::span<BoxReal> turns,
                 std::span<BoxReal> moves) const;

  /// root, the three bone centres, tip: the points that the thesis draws its curve on, riding on
  /// their bones (R21, R24).
  static std::array<glm::dvec3, 5> five_points(const Pose& pose);
  static std::array<BoxVector, 5> five_points(const BoxPose& pose);
  /// The steps between them.
  static std::array<BoxVector, 4> five_steps(const BoxPose& pose);

  /// Axis `i` (0 along the bone, 1 forward, 2 left) of bone `k` in a pose.
  glm::dvec3 axis(const Pose& pose, int k, int i) const { return pose.turn[k] * axes[k][i]; }

  Pose rest;
  std::array<glm::dmat3, 3> axes;  // of bone and control at rest, in columns

 private:
  /// Joints and turns from the three controls' Euler turns, each in its control's rest frame.
  template <class Math, class Posed>
  void carry(const std::array<typename Math::Turn, 3>& euler, Posed& p) const {
    p.joint[0] = rest.joint[0];
    for (std::size_t k = 0; k < 3; ++k) {
      // A control turns in its rest frame, and the bones below carry the result.
      const typename Math::Turn turn = euler_turn(axes[k], euler[k]);
      p.turn[k] = k == 0 ? turn : p.turn[k - 1] * turn;
      const typename Math::Vector bone(rest.joint[k + 1] - rest.joint[k]);
      p.joint[k + 1] = p.joint[k] + p.turn[k] * bone;
    }
  }
};

/// Why systems on these bones have no channel hip.
inline constexpr std::string_view kNoHipControl =
    "no control turns the hips; the same bend is an extension, seen from the chest";

/// The nine control values for a turn of the chest: all of it on Top, or half on Middle, half on
/// Top.
template <class Real>
std::vector<Real> fk_controls(const Real& rx, const Real& ry, const Real& rz, Mapping mapping) {
  const Real no = 0.0, half = 0.5;
  if (mapping == Mapping::chest) return {no, no, no, no, no, no, rx, ry, rz};
  return {no, no, no, half * rx, half * ry, half * rz, half * rx, half * ry, half * rz};
}

/// The nine control values of a body pose: chest puts all of it on Top, spread half on Middle and
/// half on Top. Channels add and never wrap.
std::vector<double> fk_controls_for(const BodyPose& body, Mapping mapping);

}  // namespace backbend::solver
