#include "validate/metrics/chain/chain.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace backbend::validate {
namespace {

// Below these a chain hardly bends or twists, and a ratio would compare rounding with rounding.
constexpr double kLeastMeanTurn = 0.05;   // degrees per joint
constexpr double kLeastTotalTwist = 1.0;  // degrees along the chain

bool finite(const solver::SpinePose& pose) {
  return std::ranges::all_of(pose.position, [](const auto& p) { return is_finite(p); }) &&
         std::ranges::all_of(pose.turn, [](const auto& q) { return is_finite(q); }) &&
         std::ranges::all_of(pose.flip_margin, [](double m) { return std::isfinite(m); }) &&
         is_finite(pose.chest.turn) && is_finite(pose.chest.posed_origin) &&
         is_finite(pose.arms.turn) && is_finite(pose.arms.posed_origin) &&
         is_finite(pose.hip.turn) && is_finite(pose.hip.posed_origin);
}

/// A polyline that can be asked for the point at a share of its length.
class Polyline {
 public:
  explicit Polyline(std::span<const glm::dvec3> point) : point_(point), arc_(point.size(), 0.0) {
    for (std::size_t i = 1; i < point.size(); ++i)
      arc_[i] = arc_[i - 1] + glm::distance(point[i - 1], point[i]);
  }

  glm::dvec3 at(double share) const {
    const double arc = std::clamp(share, 0.0, 1.0) * arc_.back();
    const auto above = std::upper_bound(arc_.begin() + 1, arc_.end() - 1, arc);
    const std::size_t i = static_cast<std::size_t>(above - arc_.begin());
    const double step = arc_[i] - arc_[i - 1];
    return step > 0.0 ? glm::mix(point_[i - 1], point_[i], (arc - arc_[i - 1]) / step)
                      : point_[i - 1];
  }

  /// Share of the length of the point nearest to `p`; the first of equally near ones.
  double nearest(const glm::dvec3& p) const {
    if (arc_.back() == 0.0) return 0.0;
    double best = std::numeric_limits<double>::infinity(), share = 0.0;
    for (std::size_t i = 1; i < point_.size(); ++i) {
      const glm::dvec3 step = point_[i] - point_[i - 1];
      const double squared = glm::dot(step, step);
      const double u =
          squared > 0.0 ? std::clamp(glm::dot(p - point_[i - 1], step) / squared, 0.0, 1.0) : 0.0;
      const glm::dvec3 gap = p - (point_[i - 1] + u * step);
      if (glm::dot(gap, gap) < best) {
        best = glm::dot(gap, gap);
        share = (arc_[i - 1] + u * (arc_[i] - arc_[i - 1])) / arc_.back();
      }
    }
    return share;
  }

 private:
  std::span<const glm::dvec3> point_;
  std::vector<double> arc_;
};

/// Turning at each inner joint of a chain and over the same stretches of a curve.
struct Turning {
  std::vector<glm::dvec3> chain, curve;  // one per joint; zero at the ends
  std::vector<char> doubles_back;        // the chain reverses and the curve does not
};

Turning turning(std::span<const glm::dvec3> joint, std::span<const glm::dvec3> curve_points) {
  const Polyline curve(curve_points), chain(joint);
  const std::size_t n = joint.size();
  const double first = curve.nearest(joint.front()), last = curve.nearest(joint.back());
  std::vector<glm::dvec3> goal(n);
  const double whole = chain_length(joint);
  double arc = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    if (i > 0) arc += glm::distance(joint[i - 1], joint[i]);
    goal[i] = curve.at(first + (last - first) * (whole > 0.0 ? arc / whole : 0.0));
  }
  Turning out{std::vector<glm::dvec3>(n, glm::dvec3(0.0)),
              std::vector<glm::dvec3>(n, glm::dvec3(0.0)), std::vector<char>(n, 0)};
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const glm::dvec3 below = joint[i] - joint[i - 1], above = joint[i + 1] - joint[i];
    const glm::dvec3 curve_below = goal[i] - goal[i - 1], curve_above = goal[i + 1] - goal[i];
    out.chain[i] = arc_between(below, above);
    out.curve[i] = arc_between(curve_below, curve_above);
    out.doubles_back[i] = glm::dot(below, above) < 0.0 && glm::dot(curve_below, curve_above) > 0.0;
  }
  return out;
}

void measure_bend(const ChainInput& in, ChainMeasures& out) {
  const Turning posed = turning(in.pose.position, in.intended);
  const Turning rest = turning(in.rest.position, in.intended_rest);
  const std::size_t n = in.pose.position.size();
  out.turn_deg.assign(n, 0.0);
  out.intended_deg.assign(n, 0.0);
  out.excess_deg.assign(n, 0.0);
  double sum = 0.0, largest = 0.0;
  for (std::size_t i = 1; i + 1 < n; ++i) {
    // The frame below the joint carries rest's turning along.
    const glm::dquat& frame = in.pose.turn[i - 1];
    const glm::dvec3 rest_excess = frame * (rest.chain[i] - rest.curve[i]);
    out.turn_deg[i] = degrees(glm::length(posed.chain[i]));
    out.intended_deg[i] = degrees(glm::length(posed.curve[i]));
    out.excess_deg[i] = degrees(glm::length(posed.chain[i] - posed.curve[i] - rest_excess));
    const double change = degrees(glm::length(posed.chain[i] - frame * rest.chain[i]));
    sum += change;
    largest = std::max(largest, change);
    if (out.excess_deg[i] > out.kink_deg) {
      out.kink_deg = out.excess_deg[i];
      out.kink_joint = static_cast<int>(i);
    }
    if (out.turn_deg[i] > out.max_turn_deg) {
      out.max_turn_deg = out.turn_deg[i];
      out.max_turn_joint = static_cast<int>(i);
    }
    if (posed.doubles_back[i] && !rest.doubles_back[i]) out.reversed.push_back(static_cast<int>(i));
  }
  const double mean = n > 2 ? sum / static_cast<double>(n - 2) : 0.0;
  if (mean > kLeastMeanTurn) out.max_over_mean = largest / mean;
}

/// The difference of order `order` of the values from `first` on, over what opposite values of 1
/// and -1 in its middle make it.
double difference(std::span<const double> values, std::size_t order, std::size_t first) {
  double sum = 0.0, middle = 0.0, coefficient = 1.0;
  for (std::size_t k = 0; k <= order; ++k) {
    sum += (k % 2 == 0 ? coefficient : -coefficient) * values[first + k];
    if (k == (order - 1) / 2 || k == (order + 1) / 2) middle += coefficient;
    coefficient *= static_cast<double>(order - k) / static_cast<double>(k + 1);
  }
  return std::abs(sum) / middle;
}

/// `twist`: of all joints but the first and the last. A smooth course leaves little in differences
/// of high order, a roll of one joint as much as in any; which of a window's joints it is, the
/// nearest four twists tell.
void measure_twist_jump(std::span<const double> twist, ChainMeasures& out) {
  constexpr std::size_t kHighest = 5, kLocal = 3;
  const std::size_t count = twist.size(), order = std::min(kHighest, count - 1);
  const std::size_t last_window = count - 1 - order;
  for (std::size_t window = 0, i = 1; window <= last_window; ++window) {
    double sharpest = -1.0;
    std::size_t joint = i;
    // The windows at the ends are for the joints nearest to them as well.
    for (; i + 2 < count && (i <= window + (order - 1) / 2 || window == last_window); ++i) {
      const double local = difference(twist, kLocal, i - 1);
      if (local > sharpest) {
        sharpest = local;
        joint = i;
      }
    }
    const double jump = difference(twist, order, window);
    if (jump > out.twist_jump_deg) {
      out.twist_jump_deg = jump;
      out.twist_jump_joint = static_cast<int>(joint) + 1;
    }
  }
}

void measure_twist(const ChainInput& in, ChainMeasures& out) {
  const std::size_t n = in.pose.turn.size();
  const double rest_length = chain_length(in.rest.position);
  out.twist_deg.assign(n, 0.0);
  double largest_rate = 0.0, total = 0.0, covered = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t bone = std::min(i, n - 2);
    const glm::dvec3 along = in.rest.position[bone + 1] - in.rest.position[bone];
    const glm::dquat& below = i == 0 ? in.pose.hip.turn : in.pose.turn[i - 1];
    if (glm::length(along) == 0.0) continue;
    const glm::dvec3 axis = below * glm::normalize(along);
    const double twist = twist_about(in.pose.turn[i] * glm::conjugate(below), axis);
    out.twist_deg[i] = degrees(twist);
    out.carried_twist_deg += degrees(twist);
    if (i == 0 || i + 1 == n) continue;  // half a bone each, and a tip repeats its bone
    const double stretch = 0.5 * (glm::distance(in.rest.position[i - 1], in.rest.position[i]) +
                                  glm::distance(in.rest.position[i], in.rest.position[i + 1]));
    if (stretch <= 1e-9 * rest_length) continue;
    largest_rate = std::max(largest_rate, std::abs(degrees(twist)) / stretch);
    total += std::abs(degrees(twist));
    covered += stretch;
  }
  if (total > kLeastTotalTwist) out.uneven_twist = largest_rate * covered / total;
  // Between the first and the last bone: hip and tip have no twist of their own to compare with.
  if (n >= kLeastTwistJumpJoints)
    measure_twist_jump(std::span(out.twist_deg).subspan(1, n - 2), out);
  out.lost_twist_deg = in.expected_twist_deg - out.carried_twist_deg;
}

void measure_length(const ChainInput& in, ChainMeasures& out) {
  const double rest_length = chain_length(in.rest.position);
  out.length = chain_length(in.pose.position) / rest_length;
  out.length_change = std::abs(out.length / in.expected_length - 1.0);
  // What the gap is at rest (a chain that ends below the chest) is no fault of the pose.
  const glm::dvec3 gap = in.rest.position.back() - in.rest.chest.posed_origin;
  out.end_gap =
      glm::length(in.pose.position.back() - in.pose.chest.posed_origin - in.pose.chest.turn * gap) /
      rest_length;
  for (std::size_t i = 0; i + 1 < in.pose.position.size(); ++i) {
    const glm::dvec3 bone = in.pose.position[i + 1] - in.pose.position[i];
    const glm::dvec3 frame = in.pose.turn[i] * (in.rest.position[i + 1] - in.rest.position[i]);
    if (glm::length(bone) > 0.0 && glm::length(frame) > 0.0)
      out.aim_gap_deg = std::max(out.aim_gap_deg, degrees(angle_between(bone, frame)));
  }
}

void measure_margin(const solver::SpinePose& pose, ChainMeasures& out) {
  for (std::size_t i = 0; i < pose.flip_margin.size(); ++i)
    if (!(degrees(pose.flip_margin[i]) >= out.least_margin_deg)) {
      out.least_margin_deg = degrees(pose.flip_margin[i]);
      out.least_margin_joint = static_cast<int>(i);
    }
}

/// Of a joint against the one below it, of the first against the hips.
glm::dquat turn_of(const solver::SpinePose& pose, std::size_t joint) {
  return glm::conjugate(joint == 0 ? pose.hip.turn : pose.turn[joint - 1]) * pose.turn[joint];
}

}  // namespace

glm::dvec3 sum_of_turns(const solver::SpinePose& pose) {
  glm::dvec3 sum(0.0);
  for (std::size_t k = 0; k < pose.turn.size(); ++k) sum += rotation_vector(turn_of(pose, k));
  return sum;
}

glm::dvec3 sum_of_turns(const solver::SpinePose& from, const solver::SpinePose& to) {
  glm::dvec3 sum(0.0);
  for (std::size_t k = 0; k < from.turn.size(); ++k)
    sum += rotation_vector(glm::conjugate(turn_of(from, k)) * turn_of(to, k));
  return sum;
}

double chain_length(std::span<const glm::dvec3> joint) {
  double length = 0.0;
  for (std::size_t i = 1; i < joint.size(); ++i) length += glm::distance(joint[i - 1], joint[i]);
  return length;
}

ArmDrift arm_drift(const solver::SpinePose& pose, const glm::dvec3& axis, double length) {
  const glm::dquat between = pose.arms.turn * glm::conjugate(pose.chest.turn);
  const glm::dvec3 held = pose.chest.turn * axis;
  return {degrees(angle_between(pose.chest.turn, pose.arms.turn)),
          degrees(twist_about(between, held)), degrees(angle_between(held, pose.arms.turn * axis)),
          glm::distance(pose.arms.posed_origin, pose.chest.apply(pose.arms.rest_origin)) / length};
}

std::vector<glm::dvec3> rest_excess(const solver::SpinePose& rest,
                                    std::span<const glm::dvec3> intended_rest) {
  const Turning at_rest = turning(rest.position, intended_rest);
  std::vector<glm::dvec3> excess;
  for (std::size_t i = 0; i < rest.position.size(); ++i)
    excess.push_back(at_rest.chain[i] - at_rest.curve[i]);
  return excess;
}

ChainMeasures measure_chain(const ChainInput& in) {
  assert(in.pose.position.size() >= 2 && in.pose.position.size() == in.rest.position.size());
  assert(in.pose.turn.size() == in.pose.position.size());
  assert(in.intended.size() >= 2 && in.intended_rest.size() >= 2);
  ChainMeasures out;
  const auto is_point = [](const glm::dvec3& p) { return is_finite(p); };
  out.finite = finite(in.pose) && std::ranges::all_of(in.intended, is_point);
  if (!out.finite) return out;
  measure_bend(in, out);
  measure_twist(in, out);
  measure_length(in, out);
  measure_margin(in.pose, out);
  const std::size_t n = in.rest.position.size();
  const glm::dvec3 axis = in.rest.position[n - 1] - in.rest.position[n - 2];
  out.arms = arm_drift(in.pose, glm::normalize(axis), chain_length(in.rest.position));
  return out;
}

double hidden_euler_twist(double y, double z) {
  return wrapped(2.0 * std::atan2(std::sin(0.5 * y) * std::sin(0.5 * z),
                                  std::cos(0.5 * y) * std::cos(0.5 * z)));
}

ArmDriftStory explain_arm_drift(const ArmDrift& drift, std::span<const EulerChannels> controls,
                                bool roll_from_last) {
  ArmDriftStory story;
  for (std::size_t i = 0; i < controls.size(); ++i) {
    story.hidden_euler_deg += degrees(hidden_euler_twist(controls[i].y, controls[i].z));
    if (roll_from_last && i + 1 < controls.size()) story.lost_twist_deg -= degrees(controls[i].x);
  }
  story.holonomy_deg = degrees(
      wrapped(radians_from(drift.twist_deg - story.hidden_euler_deg - story.lost_twist_deg)));
  return story;
}

PoseDifference pose_difference(const solver::SpinePose& a, const solver::SpinePose& b,
                               double length) {
  assert(a.position.size() == b.position.size() && a.turn.size() == b.turn.size());
  PoseDifference out;
  int turned = -1;
  for (std::size_t i = 0; i < a.position.size(); ++i) {
    const double shift = glm::distance(a.position[i], b.position[i]) / length;
    const double turn = degrees(angle_between(a.turn[i], b.turn[i]));
    if (!(shift <= out.shift)) {  // NaN is kept, and never hidden by a later number
      out.shift = shift;
      out.joint = static_cast<int>(i);
    }
    if (!(turn <= out.turn_deg)) {
      out.turn_deg = turn;
      turned = static_cast<int>(i);
    }
    if (std::isnan(out.shift) || std::isnan(out.turn_deg)) break;
  }
  if (out.joint < 0) out.joint = turned;
  return out;
}

solver::SpinePose mirrored(const solver::SpinePose& pose, const glm::dvec3& left,
                           const glm::dvec3& origin) {
  const auto point = [&](const glm::dvec3& p) {
    return p - 2.0 * glm::dot(p - origin, left) * left;
  };
  // A mirror turns a rotation's axis over, and keeps the part of it that stands square to it.
  const auto turn = [&](const glm::dquat& q) {
    const glm::dvec3 v(q.x, q.y, q.z);
    const glm::dvec3 m = 2.0 * glm::dot(v, left) * left - v;
    return glm::dquat(q.w, m.x, m.y, m.z);
  };
  const auto motion = [&](const solver::RigidMotion& m) {
    return solver::RigidMotion{turn(m.turn), point(m.rest_origin), point(m.posed_origin)};
  };
  solver::SpinePose out;
  for (const glm::dvec3& p : pose.position) out.position.push_back(point(p));
  for (const glm::dquat& q : pose.turn) out.turn.push_back(turn(q));
  out.hip = motion(pose.hip);
  out.chest = motion(pose.chest);
  out.arms = motion(pose.arms);
  return out;
}

Response response(const glm::dquat& control_before, const glm::dquat& control_after,
                  const glm::dquat& end_before, const glm::dquat& end_after) {
  const glm::dvec3 asked = turn_between(control_before, control_after);
  const glm::dvec3 given = turn_between(end_before, end_after);
  const double amount = glm::length(asked);
  if (amount == 0.0) return {std::numeric_limits<double>::quiet_NaN(), 0.0};
  const double answer = glm::length(given);
  return {answer / amount, answer > 0.0 ? degrees(angle_between(asked, given)) : 0.0};
}

}  // namespace backbend::validate
