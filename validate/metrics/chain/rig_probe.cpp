#include "validate/metrics/chain/rig_probe.h"

#include "validate/metrics/chain/chain.h"

namespace backbend::validate {

FlipRig probe(const solver::SpineSystem& system, ControlPath path) {
  std::vector<glm::dvec3> rest_bone;
  const std::vector<glm::dvec3>& joint = system.rest().position;
  for (std::size_t i = 0; i < joint.size(); ++i) {
    const std::size_t below = std::min(i, joint.size() - 2);
    const glm::dvec3 bone = joint[below + 1] - joint[below];
    const double length = glm::length(bone);
    rest_bone.push_back(length > 0.0 ? bone / length : glm::dvec3(0, 1, 0));
  }
  return [&system, path = std::move(path), rest_bone = std::move(rest_bone),
          pose = solver::SpinePose()](double t, FlipSample& sample) mutable {
    system.solve_into(path(t), solver::Detail::joints, pose);
    sample.turn = pose.turn;
    sample.position = pose.position;
    sample.margin = pose.flip_margin;
    sample.base = pose.hip.turn;
    sample.end = pose.chest.turn;
    sample.bone.resize(rest_bone.size());
    for (std::size_t i = 0; i < rest_bone.size(); ++i) sample.bone[i] = pose.turn[i] * rest_bone[i];
    sample.hanging = pose.hanging.size();
    for (const solver::RigidMotion& joint : pose.hanging) {
      sample.turn.push_back(joint.turn);
      sample.position.push_back(joint.posed_origin);
      // Away from what it hangs from: the best that is known of where its bone points.
      const double length = glm::length(joint.rest_origin);
      sample.bone.push_back(length > 0.0 ? joint.turn * (joint.rest_origin / length)
                                         : glm::dvec3(0, 1, 0));
    }
  };
}

void prepare_search(const solver::SpineSystem& system, const ControlPath& path, int intervals) {
  std::vector<std::vector<double>> controls;
  const auto add = [&](double t) { controls.push_back(path(t)); };
  const auto split = [&](double from, double to, int depth, const auto& self) -> void {
    // The same sums as find_flips() makes, to the last bit.
    const double width = to - from, middle = from + 0.5 * width;
    add(middle);
    if (depth > 0) {
      self(from, middle, depth - 1, self);
      self(middle, to, depth - 1, self);
    }
  };
  for (int i = 0; i <= intervals; ++i) add(static_cast<double>(i) / intervals);
  for (int i = 0; i < intervals; ++i)
    split(static_cast<double>(i) / intervals, static_cast<double>(i + 1) / intervals, 1, split);
  system.prepare(controls, solver::Detail::joints);
}

FlipSettings flip_settings(const solver::SpineSystem& system, int intervals, double control_deg) {
  FlipSettings settings;
  settings.intervals = intervals;
  settings.control_deg = control_deg;
  settings.length = chain_length(system.rest().position);
  settings.fraction = system.arc_fraction();
  return settings;
}

ControlPath straight_path(const solver::SpineSystem& system, const solver::BodyPose& from,
                          const solver::BodyPose& to, solver::Mapping mapping) {
  return [&system, from, to, mapping](double t) {
    const auto between = [t](double a, double b) { return a + (b - a) * t; };
    return system.controls_for(
        {between(from.extension, to.extension), between(from.flexion, to.flexion),
         between(from.side, to.side), between(from.twist, to.twist), between(from.hip, to.hip),
         between(from.stretch, to.stretch)},
        mapping);
  };
}

}  // namespace backbend::validate
