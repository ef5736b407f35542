#include "solver/systems/fk_bones.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "solver/math/fast_trigonometry.h"
#include "solver/math/rotation.h"
#include "solver/systems/system_base.h"

namespace backbend::solver {
namespace {

constexpr int kChannels = 9;

/// from_euler_xyz() of the three controls, nine sines and cosines at a time.
std::array<glm::dquat, 3> euler_turns(std::span<const double> control) {
  double half[kChannels], s[kChannels], c[kChannels];
  bool fast = true;
  for (int i = 0; i < kChannels; ++i) {
    half[i] = 0.5 * control[i];
    fast = fast && std::abs(half[i]) <= kFastTrigonometryReach;
  }
  std::array<glm::dquat, 3> turn;
  if (!fast) {
    for (int k = 0; k < 3; ++k) {
      turn[k] = from_euler_xyz(control[3 * k], control[3 * k + 1], control[3 * k + 2]);
    }
    return turn;
  }
  sin_cos_block<kChannels>(half, s, c);
  for (int k = 0; k < 3; ++k) turn[k] = from_half_angles(s + 3 * k, c + 3 * k);
  return turn;
}

}  // namespace

FkBones::FkBones(const RestChain& chain, const std::string& system) {
  check_chain(chain, system, 2);
  const std::vector<glm::dvec3> joint = three_bones_of(chain);
  // A chain that doubles back may have two of its thirds in one place.
  const double least = 1e-9 * polyline_arcs(chain.joint).back();
  for (int k = 0; k < 3; ++k) {
    if (!(glm::distance(joint[k], joint[k + 1]) > least)) {
      throw RigError(system + ": the chain doubles back, and control " + std::to_string(k + 1) +
                     " of three has no bone left; draw the chain without the fold");
    }
  }
  for (int k = 0; k < 4; ++k) rest.joint[k] = joint[k];
  for (int k = 0; k < 3; ++k) {
    axes[k] = rest_axes(joint[k + 1] - joint[k], chain.left);
    rest.turn[k] = kNoTurn;
  }
}

FkBones::Pose FkBones::pose(std::span<const double> control) const {
  assert(control.size() >= kChannels);
  const auto own = control.first(kChannels);
  if (std::all_of(own.begin(), own.end(), [](double c) { return c == 0.0; })) return rest;
  Pose p;
  carry<PoseMath>(euler_turns(own), p);
  return p;
}

FkBones::BoxPose FkBones::pose(std::span<const BoxReal> control) const {
  assert(control.size() >= kChannels);
  std::array<BoxTurn, 3> euler;
  for (std::size_t k = 0; k < 3; ++k) {
    euler[k] = from_euler_xyz(control[3 * k], control[3 * k + 1], control[3 * k + 2]);
  }
  BoxPose p;
  carry<BoxMath>(euler, p);
  // A control's RX leaves its bone where it is, which intervals do not see.
  for (std::size_t k = 0; k < 3; ++k) {
    const BoxTurn still =
        euler_turn(axes[k], from_euler_xyz(BoxReal(0.0), control[3 * k + 1], control[3 * k + 2]));
    const BoxVector bone(rest.joint[k + 1] - rest.joint[k]);
    p.bone[k] = (k == 0 ? still : p.turn[k - 1] * still) * bone;
    p.joint[k + 1] = p.joint[k] + p.bone[k];
  }
  return p;
}

FkBones::BoxPose FkBones::pose_from_middle(std::span<const BoxReal> control) const {
  const auto turn = [&](std::size_t k, const BoxReal& roll, bool rolls_alone) {
    const BoxReal no(0.0);
    return euler_turn(axes[k], from_euler_xyz(roll, rolls_alone ? no : control[3 * k + 1],
                                              rolls_alone ? no : control[3 * k + 2]));
  };
  const BoxReal no(0.0);
  const BoxTurn roll = turn(1, control[3], true);
  BoxPose p;
  p.turn = {conjugate(turn(1, no, false)), roll, roll * turn(2, control[6], false)};
  const std::array<BoxTurn, 3> still{p.turn[0], BoxTurn(), roll * turn(2, no, false)};
  for (std::size_t k = 0; k < 3; ++k) {
    p.bone[k] = still[k] * BoxVector(rest.joint[k + 1] - rest.joint[k]);
    p.joint[k + 1] = p.joint[k] + p.bone[k];
  }
  return p;
}

FkBones::PoseLanes FkBones::pose(const std::array<Lanes, kChannels>& control, int& good) const {
  std::array<Lanes, kChannels> s, c;
  Lanes most(0.0);
  for (std::size_t i = 0; i < kChannels; ++i) {
    const Lanes half = Lanes(0.5) * control[i];
    most = select(absolute(half) > most, absolute(half), most);
    sin_cos(half, s[i], c[i]);
  }
  good = ((most > Lanes(0.0)) & (most <= Lanes(kFastTrigonometryReach))).bits();
  PoseLanes p;
  p.joint[0] = rest.joint[0];
  for (std::size_t k = 0; k < 3; ++k) {
    const Lanes *sine = &s[3 * k], *cosine = &c[3 * k];  // from_half_angles() and euler_turn()
    const LaneVector v(cosine[2] * cosine[1] * sine[0] - sine[2] * sine[1] * cosine[0],
                       cosine[2] * sine[1] * cosine[0] + sine[2] * cosine[1] * sine[0],
                       sine[2] * cosine[1] * cosine[0] - cosine[2] * sine[1] * sine[0]);
    const Lanes w = cosine[2] * cosine[1] * cosine[0] + sine[2] * sine[1] * sine[0];
    const LaneTurn turn(w, axes[k] * v);
    p.turn[k] = k == 0 ? turn : p.turn[k - 1] * turn;
    const glm::dvec3 bone = rest.joint[k + 1] - rest.joint[k];
    p.joint[k + 1] = p.joint[k] + p.turn[k] * LaneVector(bone);
  }
  return p;
}

std::array<glm::dvec3, 5> FkBones::five_points(const Pose& pose) {
  const auto& j = pose.joint;
  return {j[0], 0.5 * (j[0] + j[1]), 0.5 * (j[1] + j[2]), 0.5 * (j[2] + j[3]), j[3]};
}

std::array<BoxVector, 5> FkBones::five_points(const BoxPose& pose) {
  const auto& j = pose.joint;
  const BoxReal half(0.5);
  return {j[0], half * (j[0] + j[1]), half * (j[1] + j[2]), half * (j[2] + j[3]), j[3]};
}

std::array<BoxVector, 4> FkBones::five_steps(const BoxPose& pose) {
  const BoxReal half(0.5);
  const auto& b = pose.bone;
  return {half * b[0], half * b[0] + half * b[1], half * b[1] + half * b[2], half * b[2]};
}

std::vector<double> fk_controls_for(const BodyPose& body, Mapping mapping) {
  return fk_controls(body.twist, -body.side, body.flexion - body.extension, mapping);
}

void FkBones::set_chest(const BodyBox& body, Mapping mapping, std::span<BoxReal> turns,
                        std::span<BoxReal> moves) const {
  turns[0] = body.twist;
  turns[1] = -body.side;
  turns[2] = -body.back;
  if (mapping != Mapping::spread) return;
  const BoxVector tip = pose(fk_controls(turns[0], turns[1], turns[2], mapping)).joint[3];
  const BoxVector move = tip - rest.joint[3];
  moves[0] = move.x;
  moves[1] = move.y;
  moves[2] = move.z;
}

}  // namespace backbend::solver
