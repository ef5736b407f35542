#include "validate/calibrate/faults.h"

#include <algorithm>
#include <cmath>

namespace backbend::validate {
namespace {

void turn_about(solver::RigidMotion& motion, const glm::dquat& turn, const glm::dvec3& pivot) {
  motion.turn = turn * motion.turn;
  motion.posed_origin = pivot + turn * (motion.posed_origin - pivot);
}

/// Turns all joints above an arc fraction, and what hangs from the last, about the chain there.
void turn_above(solver::SpinePose& pose, std::span<const double> fraction, double at,
                const glm::dvec3& vector) {
  const std::size_t n = pose.position.size();
  std::size_t first = 0;
  while (first < n && fraction[first] < at) ++first;
  if (first == n) return;
  glm::dvec3 pivot = pose.position[first];
  if (first > 0) {
    const double step = fraction[first] - fraction[first - 1];
    const double share = step > 0.0 ? (at - fraction[first - 1]) / step : 0.0;
    pivot = glm::mix(pose.position[first - 1], pose.position[first], share);
  }
  const glm::dquat turn = rotation(vector);
  for (std::size_t i = first; i < n; ++i) {
    pose.position[i] = pivot + turn * (pose.position[i] - pivot);
    pose.turn[i] = turn * pose.turn[i];
  }
  turn_about(pose.chest, turn, pivot);
  turn_about(pose.arms, turn, pivot);
}

}  // namespace

void inject_kink(solver::SpinePose& pose, std::span<const double> fraction, double at,
                 const glm::dvec3& kink) {
  turn_above(pose, fraction, at, kink);
  // Not at the first joint, which would turn the whole body.
  const double parts = static_cast<double>(fraction.size() - 1);
  for (std::size_t i = 1; i < fraction.size(); ++i)
    turn_above(pose, fraction, fraction[i], -kink / parts);
}

void inject_roll(solver::SpinePose& pose, const solver::SpinePose& rest,
                 std::span<const double> fraction, double from, double to, double roll) {
  const std::size_t n = pose.turn.size();
  for (std::size_t i = 0; i < n; ++i) {
    if (fraction[i] < from || fraction[i] >= to) continue;
    const std::size_t below = std::min(i, n - 2);
    const glm::dvec3 bone = glm::normalize(rest.position[below + 1] - rest.position[below]);
    pose.turn[i] = pose.turn[i] * rotation(bone * roll);
  }
}

void inject_arm_drift(solver::SpinePose& pose, const glm::dvec3& turn, const glm::dvec3& shift) {
  pose.arms.turn = rotation(turn) * pose.arms.turn;
  pose.arms.posed_origin += shift;
}

FlipRig inject_flip(FlipRig rig, std::size_t joint, double t, const glm::dvec3& turn) {
  return [rig = std::move(rig), joint, t, turn = rotation(turn)](double at, FlipSample& sample) {
    rig(at, sample);
    if (at > t) sample.turn[joint] = sample.turn[joint] * turn;
  };
}

void inject_slice_loss(std::vector<glm::vec3>& position, const SlicePose& pose, std::size_t slice,
                       double share, double reach) {
  const glm::dvec3 centre = pose.centre[slice];
  const double area = glm::length(pose.area[slice]);
  const glm::dvec3 normal = pose.area[slice] / area;
  // The body around the slice, and not what is beside it.
  const double radius = 3.0 * std::sqrt(area / kPi);
  const double keep = std::sqrt(1.0 - share);
  for (glm::vec3& p : position) {
    const glm::dvec3 offset = glm::dvec3(p) - centre;
    const double along = glm::dot(offset, normal) / reach;
    const glm::dvec3 across = offset - glm::dot(offset, normal) * normal;
    if (std::abs(along) >= 1.0 || glm::length(across) > radius) continue;
    const double fade = 1.0 - along * along;
    p = glm::vec3(glm::dvec3(p) - across * ((1.0 - keep) * fade * fade));
  }
}

void bind_vertex(skin::Influences& influences, std::uint16_t joint) {
  influences = {};
  influences.joint[0] = joint;
  influences.weight[0] = 1.0f;
}

void scale_weights(skin::Influences& influences, double sum) {
  double now = 0.0;
  for (float w : influences.weight) now += w;
  for (float& w : influences.weight) w = static_cast<float>(w * sum / now);
}

}  // namespace backbend::validate
