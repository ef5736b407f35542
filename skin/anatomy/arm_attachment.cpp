#include "skin/anatomy/arm_attachment.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <string_view>

#include "skin/anatomy/chain_arc.h"
#include "skin/character/joint_names.h"
#include "skin/character/matrix_facts.h"

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

/// The first joint above the chain's first two that is called neck or head; -1 for none.
int named_neck(const Character& character, const std::vector<int>& spine) {
  for (std::size_t k = 2; k < spine.size(); ++k) {
    const BodyPart part =
        read_joint_name(character.nodes[static_cast<std::size_t>(spine[k])].name).part;
    if (part == BodyPart::neck || part == BodyPart::head) return static_cast<int>(k);
  }
  return -1;
}

constexpr double kSamePlace = 1e-4;  // of the way from the world's origin

/// `DEF-spine.003` and `ORG-spine.003` are both of `spine.003`.
std::string_view without_prefix(std::string_view name) {
  constexpr std::size_t kLetters = 3;
  return name.size() > kLetters && name[kLetters] == '-' ? name.substr(kLetters + 1) : name;
}

}  // namespace

bool is_copy(const Character& character, int node, int joint) {
  const Node& copy = character.nodes[static_cast<std::size_t>(node)];
  const Node& original = character.nodes[static_cast<std::size_t>(joint)];
  const std::string_view bare = without_prefix(copy.name);
  if (node == joint || bare.size() == copy.name.size() || bare != without_prefix(original.name))
    return false;
  const glm::dvec3 a = origin(copy.world_from_node), b = origin(original.world_from_node);
  return glm::distance(a, b) <= kSamePlace * std::max(glm::length(a), glm::length(b));
}

int spine_index_above(const Character& character, const std::vector<int>& spine, int node) {
  for (; node >= 0; node = character.nodes[static_cast<std::size_t>(node)].parent) {
    const auto found = std::find_if(spine.begin(), spine.end(), [&](int joint) {
      return joint == node || is_copy(character, node, joint);
    });
    if (found != spine.end()) return static_cast<int>(found - spine.begin());
  }
  return -1;
}

ArmAttachment find_arm_attachment(const Character& character, const std::vector<int>& spine,
                                  const std::vector<int>& left_arm,
                                  const std::vector<int>& right_arm, int neck) {
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
  int nearest = nearest_index(character, spine, sum / count);
  if (neck < 0) neck = named_neck(character, spine);
  if (neck > 0) nearest = std::min(nearest, neck - 1);
  if (!left_arm.empty()) out.left = nearest;
  if (!right_arm.empty()) out.right = nearest;
  return out;
}

}  // namespace backbend::skin
