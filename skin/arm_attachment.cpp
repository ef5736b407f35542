#include "skin/arm_attachment.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "skin/chain_arc.h"
#include "skin/matrix_facts.h"

namespace backbend::skin {
namespace {

int nearest_index(const Character& character, const std::vector<int>& spine,
                  const glm::dvec3& place) {
  std::vector<glm::dvec3> joint;
  for (const int node : spine)
    joint.push_back(origin(character.nodes[static_cast<std::size_t>(node)].world_from_node));
  const double arc = nearest_arc(joint, place);
  int best = 0;
  double at = 0.0, least = arc;
  for (std::size_t k = 1; k < joint.size(); ++k) {
    at += glm::distance(joint[k - 1], joint[k]);
    if (std::abs(at - arc) >= least) continue;
    least = std::abs(at - arc);
    best = static_cast<int>(k);
  }
  return best;
}

}  // namespace

int spine_index_above(const Character& character, const std::vector<int>& spine, int node) {
  for (; node >= 0; node = character.nodes[static_cast<std::size_t>(node)].parent)
    if (const auto found = std::find(spine.begin(), spine.end(), node); found != spine.end())
      return static_cast<int>(found - spine.begin());
  return -1;
}

ArmAttachment find_arm_attachment(const Character& character, const std::vector<int>& spine,
                                  const std::vector<int>& left_arm,
                                  const std::vector<int>& right_arm) {
  ArmAttachment out;
  glm::dvec3 sum(0.0);
  double count = 0.0;
  for (const auto* arm : {&left_arm, &right_arm}) {
    if (arm->empty()) continue;
    const int index = spine_index_above(character, spine, arm->front());
    out.by_place |= index <= 0;
    (arm == &left_arm ? out.left : out.right) = index;
    sum += origin(character.nodes[static_cast<std::size_t>(arm->front())].world_from_node);
    count += 1.0;
  }
  if (!out.by_place) return out;
  const int nearest = nearest_index(character, spine, sum / count);
  if (!left_arm.empty()) out.left = nearest;
  if (!right_arm.empty()) out.right = nearest;
  return out;
}

}  // namespace backbend::skin
