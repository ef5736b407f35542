#include <algorithm>
#include <glm/gtc/quaternion.hpp>
#include <numeric>

#include "skin/anatomy/anatomy.h"
#include "skin/anatomy/arm_attachment.h"
#include "skin/anatomy/chain_arc.h"
#include "skin/character/matrix_facts.h"
#include "solver/rig/box_solver.h"

namespace backbend::skin {
namespace {

using Index = std::size_t;
using solver::RigidMotion;

// What moves a node, rest to pose: nothing, the hips, or (from kChain on) a spine joint.
constexpr int kStatic = 0, kHip = 1, kChain = 2;

// Thighs start at the hips whatever joint they hang from; a fish's hind fins do not.
constexpr double kLegsStartBelow = 0.25;  // of the spine's length

bool is_identity(const RigidMotion& motion) {
  return motion.turn == glm::dquat(1.0, 0.0, 0.0, 0.0) && motion.rest_origin == motion.posed_origin;
}

/// The way from one rotation to another that is shorter than half a turn.
glm::dquat shortest_between(const glm::dquat& from, const glm::dquat& to, double fraction) {
  if (from == to) return from;            // slerp would round the rest pose
  return glm::slerp(from, to, fraction);  // glm::slerp takes the short way; glm::mix does not
}
solver::BoxTurn shortest_between(const solver::BoxTurn& from, const solver::BoxTurn& to,
                                 double fraction) {
  return fraction == 0.0 ? from : solver::slerp_short(from, to, fraction);
}

glm::dvec3 share_of_way(const glm::dvec3& low, const glm::dvec3& high, double share) {
  return glm::mix(low, high, share);
}
solver::BoxVector share_of_way(const solver::BoxVector& low, const solver::BoxVector& high,
                               double share) {
  return solver::BoxReal(1.0 - share) * low + solver::BoxReal(share) * high;
}

/// One pose, or a box of them.
struct OnePose : solver::PoseMath {
  using Pose = solver::SpinePose;
  using Motion = RigidMotion;
};
struct BoxOfPoses : solver::BoxMath {
  using Pose = solver::BoxPlaces;
  using Motion = solver::BoxMotion;
};

/// The posed chain as a motion of any point beside it: between two of its joints the way they went
/// is shared by arc fraction, beyond its ends the end joint carries rigidly.
template <class Math>
class ChainMotion {
  using Turn = typename Math::Turn;
  using Vector = typename Math::Vector;
  using Motion = typename Math::Motion;

 public:
  ChainMotion(const solver::SpineSystem& system, const typename Math::Pose& pose)
      : rest_(system.rest()), pose_(pose), fraction_(system.arc_fraction()) {
    order_.resize(std::min(fraction_.size(), pose.position.size()));
    std::iota(order_.begin(), order_.end(), Index{0});
    // Some systems count from the head or the tail.
    std::stable_sort(order_.begin(), order_.end(),
                     [&](Index a, Index b) { return fraction_[a] < fraction_[b]; });
  }

  Motion at(double fraction, const glm::dvec3& rest_joint) const {
    const auto above = std::upper_bound(order_.begin(), order_.end(), fraction,
                                        [&](double f, Index k) { return f < fraction_[k]; });
    if (above == order_.end()) return carried_by(order_.back(), rest_joint);
    if (above == order_.begin()) return from_hip(*above, fraction, rest_joint);
    const Index low = *(above - 1), high = *above;
    const double share = (fraction - fraction_[low]) / (fraction_[high] - fraction_[low]);
    return between(rest_.position[low], pose_.position[low], pose_.turn[low], high, share,
                   rest_joint);
  }

 private:
  Motion carried_by(Index joint, const glm::dvec3& rest_joint) const {
    const Turn& turn = pose_.turn[joint];
    return {turn, rest_joint,
            moved(turn, rest_joint, rest_.position[joint], pose_.position[joint])};
  }

  /// Below the first joint of systems whose joints start above the hips: from the hips' motion on.
  Motion from_hip(Index first, double fraction, const glm::dvec3& rest_joint) const {
    const double share = fraction_[first] > 0.0 ? fraction / fraction_[first] : 1.0;
    return between(pose_.hip.rest_origin, pose_.hip.posed_origin, pose_.hip.turn, first, share,
                   rest_joint);
  }

  Motion between(const glm::dvec3& rest_low, const Vector& posed_low, const Turn& turn_low,
                 Index high, double share, const glm::dvec3& rest_joint) const {
    const Turn turn = shortest_between(turn_low, pose_.turn[high], share);
    const glm::dvec3 rest_on_chain = glm::mix(rest_low, rest_.position[high], share);
    const Vector way =
        share_of_way(posed_low - rest_low, pose_.position[high] - rest_.position[high], share);
    return {turn, rest_joint, moved(turn, rest_joint, rest_on_chain, rest_on_chain + way)};
  }

  /// Where a point goes that is carried rigidly; written as a sum of steps that are 0 at rest, so
  /// that rest comes out exactly.
  static Vector moved(const Turn& turn, const glm::dvec3& point, const glm::dvec3& rest_origin,
                      const Vector& posed_origin) {
    const glm::dvec3 beside = point - rest_origin;
    return point + (posed_origin - rest_origin) + (turn * Vector(beside) - beside);
  }

  const solver::SpinePose& rest_;
  const typename Math::Pose& pose_;
  const std::vector<double>& fraction_;
  std::vector<Index> order_;  // of the system's joints, by arc fraction
};

}  // namespace

SpineDriver::SpineDriver(const Character& character, const Anatomy& anatomy)
    : character_(character), anatomy_(anatomy) {
  const Index count = anatomy.chest_index + 1;
  std::vector<double> arc;
  for (Index k = 0; k < count; ++k) {
    const glm::dvec3 joint =
        origin(character.nodes[static_cast<Index>(anatomy.spine[k])].world_from_node);
    const double step = k == 0 ? 0.0 : glm::distance(joint, chain_.joint.back());
    arc.push_back(k == 0 ? 0.0 : arc.back() + step);
    // Two joints in one place are one joint of the chain.
    if (k == 0 || step > 1e-6 * anatomy.spine_length) chain_.joint.push_back(joint);
  }
  for (const double a : arc) joint_fraction_.push_back(a / arc.back());
  chain_.left = anatomy.left;
  choose_motions();
}

double SpineDriver::start_fraction(const std::vector<int>& left,
                                   const std::vector<int>& right) const {
  glm::dvec3 sum(0.0);
  int count = 0;
  for (const auto* limb : {&left, &right}) {
    if (limb->empty()) continue;
    sum += origin(character_.nodes[static_cast<Index>(limb->front())].world_from_node);
    ++count;
  }
  return nearest_arc(chain_.joint, sum / static_cast<double>(count)) / arc_length(chain_.joint);
}

void SpineDriver::choose_motions() {
  motion_.assign(character_.nodes.size(), -1);
  const auto set = [&](const std::vector<int>& chain, int motion) {
    if (!chain.empty()) motion_[static_cast<Index>(chain.front())] = motion;
  };
  const int chest = static_cast<int>(anatomy_.chest_index);
  set(anatomy_.tail, kHip);
  if (const auto& leg = anatomy_.left_leg.empty() ? anatomy_.right_leg : anatomy_.left_leg;
      !leg.empty() && (spine_index_above(character_, anatomy_.spine, leg.front()) <= 0 ||
                       start_fraction(anatomy_.left_leg, anatomy_.right_leg) <= kLegsStartBelow)) {
    set(anatomy_.left_leg, kHip);
    set(anatomy_.right_leg, kHip);
  }
  // Neck and head go with the chest, also where the skeleton is built from the head backwards.
  for (int k = 0; k < static_cast<int>(anatomy_.spine.size()); ++k)
    motion_[static_cast<Index>(anatomy_.spine[static_cast<Index>(k)])] =
        k == 0 ? kHip : kChain + std::min(k, chest);
  const ArmAttachment arms =
      find_arm_attachment(character_, anatomy_.spine, anatomy_.left_arm, anatomy_.right_arm);
  arms_follow_chest_ = arms.lowest() >= chest;
  const auto set_arm = [&](const std::vector<int>& arm, int index) {
    if (index >= 0) set(arm, index == 0 ? kHip : kChain + std::min(index, chest));
  };
  set_arm(anatomy_.left_arm, arms.left);
  set_arm(anatomy_.right_arm, arms.right);
  for (Index n = 0; n < motion_.size(); ++n) {  // parents stand before their children
    const int parent = character_.nodes[n].parent;
    if (motion_[n] < 0) motion_[n] = parent < 0 ? kStatic : motion_[static_cast<Index>(parent)];
  }
  // A loose joint and what hangs from it take over the motion of what it touches.
  for (const Follower& follower : anatomy_.followers) {
    const int from = motion_[static_cast<Index>(follower.node)];
    std::vector<bool> below(motion_.size(), false);
    below[static_cast<Index>(follower.node)] = true;
    for (Index n = 0; n < motion_.size(); ++n) {
      const int parent = character_.nodes[n].parent;
      below[n] = below[n] || (parent >= 0 && below[static_cast<Index>(parent)]);
      if (below[n] && motion_[n] == from) motion_[n] = motion_[static_cast<Index>(follower.leader)];
    }
  }
}

int SpineDriver::joint_of_motion(int motion) {
  return motion == kStatic ? -1 : std::max(0, motion - kChain);
}

std::vector<bool> SpineDriver::static_nodes() const {
  std::vector<bool> out(motion_.size());
  for (Index n = 0; n < out.size(); ++n) out[n] = motion_[n] == kStatic;
  return out;
}

std::vector<glm::dmat4> SpineDriver::drive(const solver::SpineSystem& system,
                                           const solver::SpinePose& pose) const {
  if (pose.body && pose.body->world_from_node.size() == character_.nodes.size())
    return pose.body->world_from_node;
  const ChainMotion<OnePose> chain(system, pose);
  std::vector<RigidMotion> motions(kChain + anatomy_.chest_index + 1);
  motions[kHip] = pose.hip;
  for (Index k = 1; k <= anatomy_.chest_index; ++k)
    motions[kChain + k] =
        chain.at(joint_fraction_[k],
                 origin(character_.nodes[static_cast<Index>(anatomy_.spine[k])].world_from_node));

  std::vector<glm::dmat4> out(character_.nodes.size());
  for (Index n = 0; n < out.size(); ++n) {
    const glm::dmat4& rest = character_.nodes[n].world_from_node;
    const RigidMotion& motion = motions[static_cast<Index>(motion_[n])];
    out[n] = is_identity(motion)
                 ? rest
                 : rigid_matrix(motion.turn, motion.rest_origin, motion.posed_origin) * rest;
  }
  return out;
}

std::vector<solver::BoxMotion> SpineDriver::motions_over(const solver::SpineSystem& system,
                                                         const solver::BoxPlaces& places) const {
  const ChainMotion<BoxOfPoses> chain(system, places);
  std::vector<solver::BoxMotion> motions(kChain + anatomy_.chest_index + 1);
  motions[kHip] = places.hip;
  for (Index k = 1; k <= anatomy_.chest_index; ++k)
    motions[kChain + k] =
        chain.at(joint_fraction_[k],
                 origin(character_.nodes[static_cast<Index>(anatomy_.spine[k])].world_from_node));
  return motions;
}

}  // namespace backbend::skin
