#include "solver/rig/controllers.h"

#include <algorithm>

#include "solver/math/rotation.h"

namespace backbend::solver {
namespace {

/// A square of the given edge across X at `at`, and an arrow from its middle along Y (forward on an
/// upright spine) whose head reaches beyond the outline.
ControllerShape square(const std::string& name, int color, const glm::dvec3& at,
                       const glm::dquat& frame, double edge) {
  const glm::dvec3 y = frame * glm::dvec3(0, 1, 0), z = frame * glm::dvec3(0, 0, 1);
  const double half = 0.5 * edge;
  const glm::dvec3 corner[] = {at + half * (y + z), at + half * (y - z), at - half * (y + z),
                               at + half * (z - y)};
  const glm::dvec3 tip = at + 1.4 * half * y;
  ControllerShape shape{name, color, {}};
  for (int i = 0; i < 4; ++i) shape.line.push_back({corner[i], corner[(i + 1) % 4]});
  shape.line.push_back({at, tip});
  shape.line.push_back({tip, tip - 0.3 * half * y + 0.2 * half * z});
  shape.line.push_back({tip, tip - 0.3 * half * y - 0.2 * half * z});
  return shape;
}

bool has_three_controls(const SpineSystem& system) {
  return system.name() == "three_bone" || system.name() == "curve" || system.name() == "even";
}

std::vector<ControllerShape> three_squares(const SpineSystem& system, const RestChain& chain,
                                           std::span<const double> control) {
  const std::unique_ptr<SpineSystem> bones = build_system({"three_bone", {}}, chain);
  const SpinePose rest = bones->rest();
  const SpinePose pose = bones->solve(control.first(bones->channels().size()));
  std::vector<ControllerShape> shapes;
  for (int bone = 0; bone < 3; ++bone) {
    const glm::dvec3 along = rest.position[bone + 1] - rest.position[bone];
    const glm::dquat frame = pose.turn[bone] * rest_frame(along, chain.left);
    const std::string& channel = system.channels()[std::size_t(3 * bone)].name;
    shapes.push_back(
        square(control_of(channel), bone, pose.position[bone], frame, glm::length(along)));
  }
  return shapes;
}

}  // namespace

std::vector<ControllerShape> controller_shapes(const SpineSystem& system, const RestChain& chain,
                                               std::span<const double> control) {
  if (has_three_controls(system)) return three_squares(system, chain, control);
  const SpinePose& rest = system.rest();
  const SpinePose pose = system.solve(control);
  const std::size_t last = rest.joint_count() - 1;
  double length = 0.0;
  for (std::size_t i = 0; i < last; ++i)
    length += glm::distance(rest.position[i], rest.position[i + 1]);
  const auto frame_at = [&](std::size_t joint) {
    const std::size_t below = std::min(joint, last - 1);
    return rest_frame(rest.position[below + 1] - rest.position[below], chain.left);
  };
  std::vector<ControllerShape> shapes;
  const bool is_chain_of_controls = system.name() == "neck" || system.name() == "snake";
  const double edge = length * (is_chain_of_controls ? 0.06 : 1.0 / 3.0);
  shapes.push_back(square("hip", 0, pose.hip.posed_origin, pose.hip.turn * frame_at(0), edge));
  if (is_chain_of_controls) {
    for (std::size_t joint = 8; joint < last; joint += 8) {
      shapes.push_back(square("body_" + std::to_string(joint), 1, pose.position[joint],
                              pose.turn[joint] * frame_at(joint), edge));
    }
  }
  shapes.push_back(
      square("chest", 2, pose.chest.posed_origin, pose.chest.turn * frame_at(last), edge));
  return shapes;
}

}  // namespace backbend::solver
