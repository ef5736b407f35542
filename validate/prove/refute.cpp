#include "validate/prove/refute.h"

#include <algorithm>
#include <cmath>

#include "solver/math/rotation.h"

namespace backbend::validate {
namespace {

constexpr double kLeastJumpDegrees = 1.0;  // BB001's limit
constexpr double kStep = 1e-4;             // of a channel's unit, for a gain
constexpr int kBisections = 45;

}  // namespace

Refuter::Refuter(const ProofQuestion& question, const solver::SpineSystem& system)
    : question_(question), system_(system), controls_(question.box, system, question.mapping) {}

void Refuter::solve(const Pose& pose, std::vector<glm::dquat>& turn) const {
  solver::SpinePose posed;
  system_.solve_into(controls_.at(pose), solver::Detail::joints, posed);
  turn = std::move(posed.turn);
}

Refuter::Turn Refuter::largest_turn(const std::vector<glm::dquat>& a,
                                    const std::vector<glm::dquat>& b) {
  Turn most;
  for (std::size_t k = 0; k < a.size(); ++k) {
    const double angle = solver::degrees(solver::angle_between(a[k], b[k]));
    if (angle > most.angle) most = {angle, k};
  }
  return most;
}

Refutation Refuter::gain_at(const Pose& pose, int axis, const SubBox& box) const {
  const auto j = std::size_t(axis);
  Pose from = pose, to = pose;
  const double step = std::min(kStep, box.high[j] - box.low[j]);
  from[j] = std::clamp(pose[j] - 0.5 * step, box.low[j], box.high[j] - step);
  to[j] = from[j] + step;
  std::vector<glm::dquat> a, b;
  solve(from, a);
  solve(to, b);
  const Turn turn = largest_turn(a, b);
  return {from, "BB002", turn.angle / (to[j] - from[j]), turn.joint, axis};
}

Refutation Refuter::bisected(Pose from, Pose to, int axis) const {
  const auto j = std::size_t(axis);
  std::vector<glm::dquat> a, b, c;
  solve(from, a);
  solve(to, b);
  Turn turn = largest_turn(a, b);
  Refutation steepest{from, "BB002", turn.angle / (to[j] - from[j]), turn.joint, axis};
  for (int i = 0; i < kBisections; ++i) {
    Pose middle = from;
    middle[j] = 0.5 * (from[j] + to[j]);
    if (!(middle[j] > from[j] && middle[j] < to[j])) break;
    solve(middle, c);
    const Turn lower = largest_turn(a, c), upper = largest_turn(c, b);
    if (lower.angle > upper.angle) {
      to = middle;
      b = c;
      turn = lower;
    } else {
      from = middle;
      a = c;
      turn = upper;
    }
    const double gain = turn.angle / (to[j] - from[j]);
    // Below this a step is rounding; above it, what is left of the turn tells jump from motion.
    if (to[j] - from[j] > 1e-7 && gain > steepest.value) {
      steepest = {from, "BB002", gain, turn.joint, axis};
    }
  }
  if (turn.angle >= kLeastJumpDegrees) return {from, "BB001", turn.angle, turn.joint, axis};
  return steepest;
}

std::optional<Refutation> Refuter::search(const SubBox& box) const {
  const auto axes = question_.box.axis.size();
  std::optional<Refutation> worst;
  const auto take = [&](const Refutation& found) {
    const bool breaks = found.check == "BB001" || found.value > question_.gain;
    if (!breaks) return;
    const bool is_jump = found.check == "BB001";
    const bool had_jump = worst && worst->check == "BB001";
    if (!worst || (is_jump && !had_jump) || (is_jump == had_jump && found.value > worst->value))
      worst = found;
  };
  Pose middle{};
  for (std::size_t j = 0; j < axes; ++j) middle[j] = 0.5 * box.low[j] + 0.5 * box.high[j];
  for (std::size_t j = 0; j < axes; ++j) {
    if (question_.box.axis[j].varies()) take(gain_at(middle, int(j), box));
  }

  // Edges: symmetric rigs have their singular poses where channels are 0, which splitting makes an
  // edge of boxes.
  std::array<std::vector<glm::dquat>, 1 << kProofAxes> corner;
  const auto corner_pose = [&](unsigned c) {
    Pose pose{};
    for (std::size_t j = 0; j < axes; ++j) pose[j] = c >> j & 1 ? box.high[j] : box.low[j];
    return pose;
  };
  const auto turns_at = [&](unsigned c) -> const std::vector<glm::dquat>& {
    if (corner[c].empty()) solve(corner_pose(c), corner[c]);
    return corner[c];
  };
  for (std::size_t j = 0; j < axes; ++j) {
    if (!question_.box.axis[j].varies()) continue;
    for (unsigned c = 0; c < 1u << axes; ++c) {
      const unsigned to = c | 1u << j;
      if (c == to) continue;
      bool once = true;  // of the corners that are one where a channel is fixed, take the first
      for (std::size_t k = 0; k < axes; ++k) {
        if (!question_.box.axis[k].varies() && (c >> k & 1)) once = false;
      }
      if (!once) continue;
      const Turn turn = largest_turn(turns_at(c), turns_at(to));
      if (turn.angle > 0.5 * question_.gain * (box.high[j] - box.low[j])) {
        take(bisected(corner_pose(c), corner_pose(to), int(j)));
      }
      if (!worst) take(gain_at(corner_pose(c), int(j), box));
    }
  }
  // The figure that anybody gets who measures at that pose.
  if (worst) worst->value = measure(*worst);
  if (worst && worst->check == "BB002" && !(worst->value > question_.gain)) return std::nullopt;
  return worst;
}

double Refuter::measure(const Refutation& claim) const {
  const auto j = std::size_t(claim.axis);
  const double end = question_.box.axis[j].high;
  const double step = claim.check == "BB001" ? 1e-9 : kStep;
  double most = 0.0;
  for (const double size : {step, step * 1e-2}) {
    Pose from = claim.pose, to = claim.pose;
    to[j] = std::min(from[j] + size, end);
    if (!(to[j] > from[j])) from[j] = to[j] - size;
    std::vector<glm::dquat> a, b;
    solve(from, a);
    solve(to, b);
    const double angle = largest_turn(a, b).angle;
    most = std::max(most, claim.check == "BB001" ? angle : angle / (to[j] - from[j]));
  }
  return most;
}

}  // namespace backbend::validate
