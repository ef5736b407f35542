#pragma once
#include <limits>
#include <span>
#include <vector>

#include "solver/rig/spine_pose.h"
#include "validate/metrics/math/rotation.h"

namespace backbend::validate {

/// A pose of a chain beside what it is measured against. The spans must outlive the call.
struct ChainInput {
  const solver::SpinePose& pose;
  const solver::SpinePose& rest;
  std::span<const glm::dvec3> intended;  // SpineSystem::intended_curve of the pose, >= 2 points
  std::span<const glm::dvec3> intended_rest;  // the same at rest, as many points
  double expected_twist_deg = std::numeric_limits<double>::quiet_NaN();  // hips to chest; NaN: none
  double expected_length = 1.0;  // of rest: what the stretch option asks for
};

/// The turns of all joints from hips to chest, each against the one below, as rotation vectors in
/// the axes of the one below, added up: what arrives at the chest, with the full turns.
glm::dvec3 sum_of_turns(const solver::SpinePose& pose);
/// The same from one pose to another of the chain.
glm::dvec3 sum_of_turns(const solver::SpinePose& from, const solver::SpinePose& to);

/// How the arms moved against the chest control.
struct ArmDrift {
  double rotation_deg = 0.0;  // the whole turn
  double twist_deg = 0.0;     // its part about the spine's axis at the chest, signed
  double aim_deg = 0.0;       // angle between that axis as arms and as chest carry it
  double shift = 0.0;         // of the arm roots' origin, share of the rest length
};

/// Joints that a chain needs for one inner joint's twist to have neighbours: BB014 asks nothing of
/// fewer.
inline constexpr std::size_t kLeastTwistJumpJoints = 6;

/// Everything that is measured on one pose of a chain. Vectors have one entry per joint.
struct ChainMeasures {
  bool finite = true;  // false: nothing else was measured

  std::vector<double> turn_deg;      // angle between the bones that meet at a joint; 0 at the ends
  std::vector<double> intended_deg;  // what the intended curve turns over the same stretch
  std::vector<double> excess_deg;    // turn less intended less that of rest, as vectors
  double kink_deg = 0.0;             // the largest excess
  int kink_joint = -1;
  double max_turn_deg = 0.0;
  int max_turn_joint = -1;
  double max_over_mean = 1.0;  // of the turns less rest; 1 where the chain hardly bends
  std::vector<int> reversed;   // joints at which the chain doubles back and the curve does not

  ArmDrift arms;

  std::vector<double> twist_deg;   // of each joint against the one below (the hip's turn for the
                                   // first), about its bone, signed
  double carried_twist_deg = 0.0;  // their sum
  double lost_twist_deg = 0.0;     // expected less carried; NaN where nothing was expected
  double uneven_twist = 1.0;       // largest over mean, per length; 1 where there is hardly any
  // How far one joint is rolled against both its neighbours beyond any smooth twist: the fifth
  // difference of the joints' twists over 20 (with fewer than eight joints of a lower order), which
  // a roll of one joint by J makes J (three quarters of it one joint from the ends), and a step of
  // all joints above by J makes J / 2.
  double twist_jump_deg = 0.0;
  int twist_jump_joint = -1;

  double length = 1.0;         // of rest
  double length_change = 0.0;  // |length / expected - 1|
  double end_gap = 0.0;        // last joint to chest control, share of the rest length
  double aim_gap_deg = 0.0;    // worst angle between a joint's frame and its bone

  double least_margin_deg = std::numeric_limits<double>::quiet_NaN();  // NaN: the rig has none
  int least_margin_joint = -1;
};

/// Measures one pose of a chain.
///
/// The kink is referenced to intent: the turning of a smooth but sharply bent curve is no fault of
/// the chain, and a corner that no curve asked for is one however small the bend. Both turnings are
/// taken between the chords of the same stretches: the chain's ends are placed on the curve by
/// their nearest points, the joints between by the chain's own length.
///
/// Needs a pose and rest of the same two or more joints, and curves of two or more points.
ChainMeasures measure_chain(const ChainInput& in);

/// What each joint of the rest pose turns beyond its intended curve, as rotation vectors, radians:
/// what measure_chain() takes from the excess of every pose, carried by the bone below.
std::vector<glm::dvec3> rest_excess(const solver::SpinePose& rest,
                                    std::span<const glm::dvec3> intended_rest);

/// How the arms moved against the chest: only of the two rigid motions. `axis` is the spine's
/// direction at the chest at rest, unit; `length` the spine's at rest.
ArmDrift arm_drift(const solver::SpinePose& pose, const glm::dvec3& axis, double length);

/// Euler channels of one spine control, radians, R = Rz Ry Rx, X along its bone.
struct EulerChannels {
  double x = 0.0, y = 0.0, z = 0.0;
};

/// Where the twist part of an arm drift comes from. Degrees; the three add up to the measured one.
struct ArmDriftStory {
  double hidden_euler_deg = 0.0;  // the twist that Rz Ry holds beside its swing
  double lost_twist_deg = 0.0;    // twist of controls that feeds nothing
  double holonomy_deg = 0.0;      // the rest: bends about different axes do not commute
};

/// Explains the twist of arms that hang from the end of a chain carrying only minimal swings.
///
/// A control turned by y and z holds a twist of -2 atan(tan(y/2) tan(z/2)) against the shortest
/// arc, which a chain does not see; so arms on the chain differ by the opposite. `controls` stand
/// hips first; `roll_from_last`: only the last one's x feeds the chain (the thesis's rig), else all
/// do. Derivation: components of qz qy about X and 1, -sin(z/2) sin(y/2) and cos(z/2) cos(y/2).
ArmDriftStory explain_arm_drift(const ArmDrift& drift, std::span<const EulerChannels> controls,
                                bool roll_from_last);
/// 2 atan(tan(y/2) tan(z/2)), radians: finite for every y and z.
double hidden_euler_twist(double y, double z);

/// How two poses of one chain differ: positions as a share of `length`, turns in degrees.
struct PoseDifference {
  double shift = 0.0;
  double turn_deg = 0.0;
  int joint = -1;  // of the largest shift, or of the largest turn where nothing shifted
};
PoseDifference pose_difference(const solver::SpinePose& a, const solver::SpinePose& b,
                               double length);
/// The pose as a mirror shows it, whose plane is square to `left` (unit) through `origin`.
/// Measures, margins and flags are left out.
solver::SpinePose mirrored(const solver::SpinePose& pose, const glm::dvec3& left,
                           const glm::dvec3& origin);

/// How an end answers its control between two poses.
struct Response {
  double gain = 0.0;      // degrees of the end per degree of the control; NaN: the control rests
  double axis_deg = 0.0;  // between the axes both turn about; 0 where the end does not turn
};
/// `control` and `end` are the world turns before and after, unit.
Response response(const glm::dquat& control_before, const glm::dquat& control_after,
                  const glm::dquat& end_before, const glm::dquat& end_after);

/// Sum of the bone lengths.
double chain_length(std::span<const glm::dvec3> joint);

}  // namespace backbend::validate
