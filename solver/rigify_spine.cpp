#include "solver/rigify_spine.h"

#include <algorithm>
#include <cassert>
#include <glm/geometric.hpp>

#include "solver/rotation.h"
#include "solver/system_base.h"

namespace backbend::solver {
namespace {

using glm::dquat;
using glm::dvec3;

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
void RigifySpine::lay_joints(const Control& hips, const Control& chest, SpinePose& pose) const {
  const std::size_t bones = rest_.size() - 1;
  const std::size_t below = pivot_, above = bones - pivot_;
  const dvec3 chest_step = chest.move / double(above), hips_step = hips.move / double(below);

  // Each joint is carried by the one before, and the first of each half by nothing: it only moves.
  const dquat above_turn = slerp_short(kNoTurn, chest.turn, 1.0 / double(above));
  const dvec3 above_pivot = rest_[pivot_] + chest_step;
  dvec3 at = above_pivot;
  dquat turn = above_turn;
  for (std::size_t k = pivot_ + 1; k < bones; ++k) {
    at += turn * (rest_[k] - rest_[k - 1] + chest_step);
    turn = k + 1 < bones ? turn * above_turn : chest.turn;
    pose.position[k] = at;
    pose.turn[k] = turn;
  }
  pose.position[bones] = at + turn * (rest_[bones] - rest_[bones - 1]);

  const dquat below_turn = slerp_short(kNoTurn, hips.turn, 1.0 / double(below));
  const dvec3 below_pivot = rest_[pivot_] + hips_step;
  at = below_pivot;
  turn = below_turn;
  for (std::size_t k = pivot_ - 1; k > 0; --k) {
    at += turn * (rest_[k] - rest_[k + 1] + hips_step);
    turn = k > 1 ? turn * below_turn : hips.turn;
    pose.position[k] = at;
    pose.turn[k] = turn;
  }
  pose.position[0] = at + turn * (rest_[0] - rest_[1]);
  pose.turn[0] = turn;

  pose.position[pivot_] = 0.5 * (above_pivot + below_pivot);
  pose.turn[pivot_] = slerp_short(above_turn, below_turn, 0.5);

  const double chest_margin = short_of_half_turn(kNoTurn, chest.turn);
  const double hips_margin = short_of_half_turn(kNoTurn, hips.turn);
  for (std::size_t k = 0; k < bones; ++k) {
    // The chain's ends have all of their control's turn, so nothing of theirs goes another way.
    pose.flip_margin[k] = k == 0 || k + 1 == bones ? kPi : k < pivot_ ? hips_margin : chest_margin;
  }
  double& at_pivot = pose.flip_margin[pivot_];
  at_pivot = short_of_half_turn(above_turn, below_turn);
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
  const dvec3 side = pose.turn[k] * side_;
  pose.turn[k] = shortest_arc(carried / before, bone / now, side) * pose.turn[k];
  // A bone that shrinks to nothing may point anywhere next.
  const double left = std::min(1.0, 2.0 * now / before);
  margin = std::min({margin, kPi - angle_between(carried, bone), kPi * left * left});
}

void RigifySpine::lay(const Control& hips, const Control& chest, SpinePose& pose) const {
  const std::size_t bones = rest_.size() - 1;
  pose.position.resize(bones + 1);
  pose.turn.resize(bones + 1);
  pose.flip_margin.resize(bones + 1);
  lay_joints(hips, chest, pose);
  for (std::size_t k = 0; k < bones; ++k) {
    // Both ends of the outermost bones hang from one joint, and have its turn to the last bit; so
    // has what is above the pivot while nothing moves it.
    const bool rigid =
        k == 0 ? pivot_ > 1 : k > pivot_ && (k + 1 == bones || chest.move == dvec3(0.0));
    if (!rigid) swing_to_next(k, pose);
    pose.turn[k] = glm::normalize(pose.turn[k]);
  }
  pose.turn[bones] = pose.turn[bones - 1];
  pose.flip_margin[bones] = pose.flip_margin[bones - 1];
}

/// The turn at an arc fraction: a bone's own at its middle, between two middles in proportion, and
/// past the outermost so on, so that over a whole bone it is the bone's.
dquat RigifySpine::fine_turn(const Control& hips, const Control& chest, double fraction) const {
  const auto inner = std::upper_bound(middle_.begin() + 1, middle_.end() - 1, fraction);
  const double apart = *inner - *(inner - 1);
  const double part = apart > 0.0 ? (fraction - *(inner - 1)) / apart : 0.0;
  const double bone = double(inner - middle_.begin()) - 1.0 + part;
  const double pivot = double(pivot_), bones = double(middle_.size());
  const double of_hips = std::max(0.0, (pivot - bone) / pivot);
  const double of_chest = std::max(0.0, (bone - pivot + 1.0) / (bones - pivot));
  return slerp_short(kNoTurn, hips.turn, of_hips) * slerp_short(kNoTurn, chest.turn, of_chest);
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
