#pragma once
#include <array>
#include <glm/gtc/quaternion.hpp>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <string>
#include <vector>

#include "solver/rig/spine_system.h"
#include "solver/systems/fk_bones.h"

namespace backbend::solver {

/// A hip and a chest control and the four CVs that they place: hip, a handle along hip's X axis, a
/// handle back along chest's X axis, chest. At rest both frames have X from hip to chest.
///
/// Twelve channels in this order: hip.rx ry rz, chest.rx ry rz, hip_move.x y z, chest_move.x y z.
/// Moves are in rig space, turns in the rest frame.
class HipChest {
 public:
  static constexpr int kChannels = 12;

  /// `depth` of each handle as a fraction of the distance between hip and chest. Throws RigError
  /// for a chain that check_chain() refuses or whose ends coincide.
  HipChest(const RestChain& chain, const std::string& system, std::array<double, 2> depth);

  struct Ends {
    std::array<glm::dvec3, 4> cv;
    glm::dquat hip, chest;            // frames
    glm::dquat hip_turn, chest_turn;  // from rest
    glm::dvec3 hip_move, chest_move;  // from rest
    double twist;                     // chest RX less hip RX: never wrapped
  };
  Ends ends(std::span<const double> control) const;

  /// The turn of a control from rest, over a box of its three channels from number `first` on.
  BoxTurn turn(std::span<const BoxReal> control, std::size_t first) const {
    return euler_turn(axes_,
                      from_euler_xyz(control[first], control[first + 1], control[first + 2]));
  }

  /// The four CVs and the turns of both controls from rest, over a box of poses.
  struct BoxEnds {
    std::array<BoxVector, 4> cv;
    BoxTurn hip_turn, chest_turn;
  };
  BoxEnds ends(std::span<const BoxReal> control) const;

  const std::array<glm::dvec3, 4>& rest_cv() const { return rest_cv_; }
  const glm::dquat& rest_frame() const { return frame_; }
  /// From hip to chest at rest, unit.
  glm::dvec3 rest_direction() const { return axes_[0]; }
  double rest_length() const { return length_; }

  /// Writes the twelve values of a body pose: hip tips by hip's RZ, all else is on chest, which is
  /// moved by what the pose stretches; for spread also to where the three-bone tip would be.
  void set_body(const BodyPose& body, Mapping mapping, std::span<double> control) const;
  /// The same over a box; of the others a box has none.
  void set_body(const BodyBox& body, Mapping mapping, std::span<BoxReal> control) const;

 private:
  FkBones bones_;  // only to know where a three-bone tip would be
  std::array<double, 2> depth_;
  std::array<glm::dvec3, 4> rest_cv_;
  glm::dmat3 axes_;  // the rest frame, exact along coordinate axes
  glm::dquat frame_;
  double length_;
};

}  // namespace backbend::solver
