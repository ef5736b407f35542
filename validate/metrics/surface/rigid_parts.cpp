#include "validate/metrics/surface/rigid_parts.h"

#include <algorithm>
#include <glm/common.hpp>
#include <glm/matrix.hpp>
#include <optional>

#include "skin/character/matrix_facts.h"

namespace backbend::validate {
namespace {

/// Of axes, and of shifts in sizes of the body: more than equal motions differ by where a program
/// gives them in single precision, and far less than anybody sees.
constexpr double kSame = 1e-6;

/// Without scale, shear or mirroring.
bool is_rigid(const glm::dmat4& motion) {
  const glm::dmat3 turn(motion);
  return glm::determinant(turn) > 0.0 &&
         skin::same_motion(glm::dmat4(glm::transpose(turn) * turn), glm::dmat4(1.0), kSame, 1.0);
}

}  // namespace

RigidParts::RigidParts(const skin::Character& character, const skin::SpineDriver& driver) {
  for (const skin::SkinJoint& joint : character.joints) {
    const auto node = static_cast<std::size_t>(joint.node);
    const glm::dmat4& rest = character.nodes[node].world_from_node;
    const int part = driver.node_motions()[node];
    joint_.push_back({node, part, glm::inverse(rest)});
    parts_ = std::max(parts_, static_cast<std::size_t>(part) + 1);
    const glm::dvec3 at = glm::abs(skin::origin(rest));
    size_ = std::max({size_, at.x, at.y, at.z});
  }
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
    if (first) return skin::same_motion(here, *first, kSame, size_);
    first = here;
    return is_rigid(here);
  });
}

}  // namespace backbend::validate
