#include "validate/metrics/surface/rigid_parts.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <optional>

#include "solver/rig/spine_system.h"
#include "validate/metrics/math/rotation.h"

namespace backbend::validate {
namespace {

/// Turns, and shifts in sizes of the body: more than equal motions differ by where a program gives
/// them in single precision, and far less than anybody sees.
constexpr double kSame = 1e-6;

bool same(const glm::dmat4& a, const glm::dmat4& b, double size) {
  double turn = 0.0, shift = 0.0;
  for (int r = 0; r < 4; ++r) {
    for (int c = 0; c < 3; ++c) turn = std::max(turn, std::abs(a[c][r] - b[c][r]));
    shift = std::max(shift, std::abs(a[3][r] - b[3][r]));
  }
  return turn < kSame && shift < kSame * size;
}

/// Without scale, shear or mirroring.
bool is_rigid(const glm::dmat4& motion) {
  const glm::dmat3 turn(motion);
  return glm::determinant(turn) > 0.0 &&
         same(glm::dmat4(glm::transpose(turn) * turn), glm::dmat4(1.0), 1.0);
}

}  // namespace

RigidParts::RigidParts(const skin::Character& character, const skin::SpineDriver& driver) {
  const auto system = solver::build_system({"even", {}}, driver.rest_chain());
  solver::SpinePose pose =
      system->solve(system->controls_for({0.41, 0.0, 0.23, 0.37}, solver::Mapping::spread));
  // Other rigs let the hips go another way.
  const glm::dvec3 stray(0.11, -0.07, 0.05);
  pose.hip.turn = rotation(stray) * pose.hip.turn;
  pose.hip.posed_origin += stray;
  const std::vector<glm::dmat4> world = driver.drive(*system, pose);
  for (const skin::SkinJoint& joint : character.joints) {
    const glm::dvec3 at(character.nodes[static_cast<std::size_t>(joint.node)].world_from_node[3]);
    size_ = std::max({size_, std::abs(at.x), std::abs(at.y), std::abs(at.z)});
  }
  std::vector<glm::dmat4> motion;  // distinct ones, from rest: a part each
  for (const skin::SkinJoint& joint : character.joints) {
    const auto node = static_cast<std::size_t>(joint.node);
    const glm::dmat4 from_rest = glm::inverse(character.nodes[node].world_from_node);
    const glm::dmat4 here = world[node] * from_rest;
    const auto part = std::ranges::find_if(
        motion, [&](const glm::dmat4& other) { return same(here, other, size_); });
    joint_.push_back({node, static_cast<int>(part - motion.begin()), from_rest});
    if (part == motion.end()) motion.push_back(here);
  }
  parts_ = motion.size();
  std::vector<bool> is_used(joint_.size(), false);
  for (const skin::Influences& influences : character.influences) {
    std::optional<int> part;
    for (int k = 0; k < skin::kMaxInfluences; ++k) {
      if (influences.weight[k] == 0.0f) continue;
      const int here = joint_[influences.joint[k]].part;
      part = !part || *part == here ? here : -1;
      if (*part < 0) break;
    }
    of_vertex_.push_back(part.value_or(-1));
    for (int k = 0; k < skin::kMaxInfluences && of_vertex_.back() >= 0; ++k)
      if (influences.weight[k] != 0.0f) is_used[influences.joint[k]] = true;
  }
  std::size_t kept = 0;
  for (std::size_t j = 0; j < joint_.size(); ++j)
    if (is_used[j]) joint_[kept++] = joint_[j];
  joint_.resize(kept);
}

bool RigidParts::hold(std::span<const glm::dmat4> world_from_node) const {
  std::vector<std::optional<glm::dmat4>> motion(parts_);
  return std::ranges::all_of(joint_, [&](const Joint& joint) {
    const glm::dmat4 here = world_from_node[joint.node] * joint.node_from_rest;
    std::optional<glm::dmat4>& first = motion[static_cast<std::size_t>(joint.part)];
    if (first) return same(here, *first, size_);
    first = here;
    return is_rigid(here);
  });
}

}  // namespace backbend::validate
