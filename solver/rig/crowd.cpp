#include "solver/rig/crowd.h"

#include <cassert>

namespace backbend::solver {

void OneByOne::solve(const CrowdControls& control, std::size_t pose, CrowdPose& out) {
  const std::size_t channels = system_.channels().size();
  own_.resize(channels);
  for (std::size_t c = 0; c < channels; ++c) own_[c] = control.at(c, pose);
  system_.solve_into(own_, Detail::joints, solved_);
  const auto write = [&](std::size_t joint, const glm::dvec3& origin, const glm::dquat& turn) {
    for (int a = 0; a < 3; ++a) out.position(joint, std::size_t(a))[pose] = origin[a];
    out.turn(joint, 0)[pose] = turn.w;
    out.turn(joint, 1)[pose] = turn.x;
    out.turn(joint, 2)[pose] = turn.y;
    out.turn(joint, 3)[pose] = turn.z;
  };
  const std::size_t joints = solved_.joint_count();
  for (std::size_t j = 0; j < joints; ++j) write(j, solved_.position[j], solved_.turn[j]);
  write(joints, solved_.arms.posed_origin, solved_.arms.turn);  // the row after the joints
  out.flagged()[pose] = solved_.flags.empty() ? 0 : 1;
}

void solve_crowd(const SpineSystem& system, const CrowdControls& control, CrowdPose& out) {
  out.resize(system.joint_names().size(), control.count);
  solve_crowd(system, control, {0, control.count}, out);
}

void solve_crowd(const SpineSystem& system, const CrowdControls& control, PoseRange range,
                 CrowdPose& out) {
  assert(control.value.size() == system.channels().size() * control.count);
  assert(range.first <= range.last && range.last <= control.count);
  assert(out.joint_count() == system.joint_names().size() && out.pose_count() == control.count);
  if (const auto* crowds = dynamic_cast<const CrowdSolver*>(&system)) {
    return crowds->solve_crowd(control, range, out);
  }
  OneByOne single(system);
  for (std::size_t i = range.first; i < range.last; ++i) single.solve(control, i, out);
}

}  // namespace backbend::solver
