#include "solver/systems/rigify_spine.h"

#include <algorithm>
#include <cassert>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "solver/math/rotation.h"
#include "solver/systems/system_base.h"

namespace backbend::solver {
namespace {

using glm::dquat;
using glm::dvec3;

/// The shortest arc from where a bone is carried to where it points. Both have a length.
template <class Turn, class Vector>
Turn swung(const Vector& carried, const Vector& bone, const Vector& side) {
  using glm::length;
  return shortest_arc(carried / length(carried), bone / length(bone), side);
}

double short_of_half_turn(const dquat& a, const dquat& b) { return kPi - angle_between(a, b); }

}  // namespace

RigifySpine::RigifySpine(std::vector<dvec3> rest, std::size_t pivot, const dvec3& side)
    : rest_(std::move(rest)), pivot_(pivot), side_(side), path_(Curve::polyline(rest_)) {
  assert(pivot_ > 0 && pivot_ + 1 < rest_.size());
  const std::vector<double> arc = polyline_arcs(rest_);
  pivot_fraction_ = arc[pivot_] / arc.back();
  for (std::size_t k = 0; k + 1 < arc.size(); ++k)
    middle_.push_back(0.5 * (arc[k] + arc[k + 1]) / arc.back());
}

/// Where the joints stand, and their turns before any bone is swung to the next.
template <class Math>
void RigifySpine::lay_joints(const ControlOf<Math>& hips, const ControlOf<Math>& chest,
                             Joints<Math>& joints) const {
  using Vector = typename Math::Vector;
  using Turn = typename Math::Turn;
  using Real = typename Math::Real;
  const std::size_t bones = rest_.size() - 1;
  const std::size_t below = pivot_, above = bones - pivot_;
  const Vector chest_step = chest.move / Real(double(above)),
               hips_step = hips.move / Real(double(below));

  // Each joint is carried by the one before, and the first of each half by nothing: it only moves.
  joints.above_turn = slerp_short(kNoTurn, chest.turn, 1.0 / double(above));
  const Vector above_pivot = rest_[pivot_] + chest_step;
  Vector at = above_pivot;
  Turn turn = joints.above_turn;
  for (std::size_t k = pivot_ + 1; k < bones; ++k) {
    at = at + turn * (rest_[k] - rest_[k - 1] + chest_step);
    turn = k + 1 < bones ? turn * joints.above_turn : chest.turn;
    joints.position[k] = at;
    joints.turn[k] = turn;
  }
  joints.position[bones] = at + turn * Vector(rest_[bones] - rest_[bones - 1]);

  joints.below_turn = slerp_short(kNoTurn, hips.turn, 1.0 / double(below));
  const Vector below_pivot = rest_[pivot_] + hips_step;
  at = below_pivot;
  turn = joints.below_turn;
  for (std::size_t k = pivot_ - 1; k > 0; --k) {
    at = at + turn * (rest_[k] - rest_[k + 1] + hips_step);
    turn = k > 1 ? turn * joints.below_turn : hips.turn;
    joints.position[k] = at;
    joints.turn[k] = turn;
  }
  joints.position[0] = at + turn * Vector(rest_[0] - rest_[1]);
  joints.turn[0] = turn;

  joints.position[pivot_] = Real(0.5) * (above_pivot + below_pivot);
  joints.turn[pivot_] = slerp_short(joints.above_turn, joints.below_turn, 0.5);
}

void RigifySpine::lay_margins(const Control& hips, const Control& chest,
                              const Joints<PoseMath>& joints, std::vector<double>& margin) const {
  const std::size_t bones = rest_.size() - 1;
  const std::size_t below = pivot_, above = bones - pivot_;
  const double chest_margin = short_of_half_turn(kNoTurn, chest.turn);
  const double hips_margin = short_of_half_turn(kNoTurn, hips.turn);
  for (std::size_t k = 0; k < bones; ++k) {
    // The chain's ends have all of their control's turn, so nothing of theirs goes another way.
    margin[k] = k == 0 || k + 1 == bones ? kPi : k < pivot_ ? hips_margin : chest_margin;
  }
  double& at_pivot = margin[pivot_];
  at_pivot = short_of_half_turn(joints.above_turn, joints.below_turn);
  if (above > 1) at_pivot = std::min(at_pivot, chest_margin);
  if (below > 1) at_pivot = std::min(at_pivot, hips_margin);
}

/// Turns a bone by the shortest arc until it points from its foot to the next joint.
void RigifySpine::swing_to_next(std::size_t k, SpinePose& pose) const {
  const dvec3 carried = pose.turn[k] * (rest_[k + 1] - rest_[k]);
  const dvec3 bone = pose.position[k + 1] - pose.position[k];
  const double before = glm::length(carried), now = glm::length(bone);
  double& margin = pose.flip_margin[k];
  if (!(now > 0.0)) margin = 0.0;
  if (!(before > 0.0 && now > 0.0)) return;
  pose.turn[k] = swung<dquat>(carried, bone, pose.turn[k] * side_) * pose.turn[k];
  // A bone that shrinks to nothing may point anywhere next.
  const double left = std::min(1.0, 2.0 * now / before);
  margin = std::min({margin, kPi - angle_between(carried, bone), kPi * left * left});
}

void RigifySpine::lay(const Control& hips, const Control& chest, SpinePose& pose) const {
  const std::size_t bones = rest_.size() - 1;
  pose.position.resize(bones + 1);
  pose.turn.resize(bones + 1);
  pose.flip_margin.resize(bones + 1);
  Joints<PoseMath> joints{pose.position, pose.turn};
  lay_joints<PoseMath>(hips, chest, joints);
  lay_margins(hips, chest, joints, pose.flip_margin);
  for (std::size_t k = 0; k < bones; ++k) {
    if (!is_rigid(k, chest.move != dvec3(0.0))) swing_to_next(k, pose);
    pose.turn[k] = glm::normalize(pose.turn[k]);
  }
  pose.turn[bones] = pose.turn[bones - 1];
  pose.flip_margin[bones] = pose.flip_margin[bones - 1];
}

bool RigifySpine::is_rigid(std::size_t k, bool chest_moves) const {
  return k == 0 ? pivot_ > 1 : k > pivot_ && (k + 2 == rest_.size() || !chest_moves);
}

void RigifySpine::lay(const ControlOf<BoxMath>& hips, const ControlOf<BoxMath>& chest,
                      std::vector<BoxVector>& position, std::vector<BoxTurn>& turn) const {
  const std::size_t bones = rest_.size() - 1;
  position.resize(bones + 1);
  turn.resize(bones + 1);
  Joints<BoxMath> joints{position, turn};
  lay_joints<BoxMath>(hips, chest, joints);
  const auto rests = [](const BoxReal& x) {
    return x.value.is_zero() && std::all_of(x.slope.begin(), x.slope.end(),
                                            [](const Interval& s) { return s.is_zero(); });
  };
  const bool chest_moves = !rests(chest.move.x) || !rests(chest.move.y) || !rests(chest.move.z);
  for (std::size_t k = 0; k < bones; ++k) {
    if (is_rigid(k, chest_moves)) continue;
    turn[k] = swung<BoxTurn>(turn[k] * BoxVector(rest_[k + 1] - rest_[k]),
                             position[k + 1] - position[k], turn[k] * BoxVector(side_)) *
              turn[k];
  }
  turn[bones] = turn[bones - 1];
}

/// A bone has its own share at its middle; between two middles shares are in proportion, and past
/// the outermost they go on so, so that over a whole bone the mean is the bone's.
RigifySpine::Shares RigifySpine::fine_shares(double fraction) const {
  const auto inner = std::upper_bound(middle_.begin() + 1, middle_.end() - 1, fraction);
  const double apart = *inner - *(inner - 1);
  const double part = apart > 0.0 ? (fraction - *(inner - 1)) / apart : 0.0;
  const double bone = double(inner - middle_.begin()) - 1.0 + part;
  const double pivot = double(pivot_), bones = double(middle_.size());
  return {std::max(0.0, (pivot - bone) / pivot),
          std::max(0.0, (bone - pivot + 1.0) / (bones - pivot))};
}

dquat RigifySpine::fine_turn(const Control& hips, const Control& chest, double fraction) const {
  const Shares share = fine_shares(fraction);
  return slerp_short(kNoTurn, hips.turn, share.of_hips) *
         slerp_short(kNoTurn, chest.turn, share.of_chest);
}

BentChain RigifySpine::bent(const BoxTurn& chest, std::size_t count) const {
  BentChain chain;
  chain.turn = chest;
  for (std::size_t k = 0; k + 1 < rest_.size(); ++k) {
    // A bone hangs from the joint nearer to the pivot.
    const double share =
        k < pivot_ ? 0.0 : double(k - pivot_ + 1) / double(rest_.size() - 1 - pivot_);
    chain.bone.push_back({rest_[k + 1] - rest_[k], share});
  }
  const auto step = [&](double from, double to) {
    return BentChain::Step{path_.at_fraction(to).position - path_.at_fraction(from).position,
                           fine_shares(0.5 * (from + to)).of_chest};
  };
  for (std::size_t i = 0; i + 1 < count; ++i) {
    const double from = double(i) / double(count - 1), to = double(i + 1) / double(count - 1);
    if (from <= pivot_fraction_ && to > pivot_fraction_) {
      // Straight between points that hang from the pivot by two steps.
      const BentChain::Step below = step(from, pivot_fraction_), above = step(pivot_fraction_, to);
      chain.joint = pivot_;
      chain.fine_joint = i + 1;
      chain.gap = above;
      const double part = (to - pivot_fraction_) / (to - from);
      chain.fine.push_back({below.rest + above.rest, glm::mix(below.share, above.share, part),
                            2.0 * part * (1.0 - part) * (above.share - below.share)});
    } else {
      chain.fine.push_back(step(from, to));
    }
  }
  return chain;
}

std::vector<dvec3> RigifySpine::fine_chain(const Control& hips, const Control& chest,
                                           std::size_t count) const {
  std::vector<dvec3> point(count);
  const auto fraction = [&](std::size_t i) { return double(i) / double(count - 1); };
  // From the pivot outward: the turn of each step is that of its middle.
  const auto walk = [&](const dvec3& move, double whole, std::size_t from, int direction,
                        std::size_t steps) {
    double before = pivot_fraction_;
    dvec3 rest_before = path_.at_fraction(before).position, at = rest_before;
    for (std::size_t n = 0; n < steps; ++n) {
      const std::size_t i = direction > 0 ? from + n : from - n;
      const double now = fraction(i);
      const dvec3 rest_now = path_.at_fraction(now).position;
      const dquat turn = fine_turn(hips, chest, 0.5 * (before + now));
      at += turn * (rest_now - rest_before + ((now - before) / whole) * move);
      point[i] = at;
      before = now;
      rest_before = rest_now;
    }
  };
  std::size_t above = 0;  // the first point past the pivot
  while (fraction(above) <= pivot_fraction_) ++above;
  walk(chest.move, 1.0 - pivot_fraction_, above, 1, count - above);
  walk(hips.move, -pivot_fraction_, above - 1, -1, above);
  return point;
}

}  // namespace backbend::solver
