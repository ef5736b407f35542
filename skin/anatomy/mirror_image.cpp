#include "skin/anatomy/mirror_image.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <tuple>

#include "skin/character/joint_names.h"
#include "skin/character/matrix_facts.h"

namespace backbend::skin {
namespace {

using Index = std::size_t;

constexpr double kAsTheAxis = 0.9994;  // cosine of 2 degrees
constexpr double kTurnedMost = 0.6;    // ... of 53, as far as a body turns from the nearest axis

}  // namespace

Mirror mirror_of(const Character& character, const Anatomy& anatomy) {
  const auto at = [&](int node) {
    return origin(character.nodes[static_cast<Index>(node)].world_from_node);
  };
  Mirror mirror{anatomy.left, at(anatomy.spine.front())};
  const auto& left = anatomy.left_arm.empty() ? anatomy.left_leg : anatomy.left_arm;
  const auto& right = anatomy.right_arm.empty() ? anatomy.right_leg : anatomy.right_arm;
  if (!left.empty() && !right.empty()) mirror.middle = 0.5 * (at(left.front()) + at(right.front()));
  // The anatomy's left is one of the file's axes; a body may stand turned between two of them.
  glm::dvec3 across(0.0);
  for (const auto& [on_left, on_right] : {std::pair(&anatomy.left_arm, &anatomy.right_arm),
                                          std::pair(&anatomy.left_leg, &anatomy.right_leg)})
    if (!on_left->empty() && !on_right->empty())
      across += at(on_left->front()) - at(on_right->front());
  across -= glm::dot(across, anatomy.up) * anatomy.up;
  const double length = glm::length(across);
  const double cosine = length > 0.0 ? glm::dot(across, anatomy.left) / length : 0.0;
  if (cosine > kTurnedMost && cosine < kAsTheAxis) mirror.left = across / length;
  return mirror;
}

glm::dmat3 body_axes(const Anatomy& anatomy, const Mirror& mirror) {
  return {mirror.left, anatomy.up, glm::cross(mirror.left, anatomy.up)};
}

bool spine_is_in_the_middle(const Character& character, const Anatomy& anatomy,
                            const Mirror& mirror) {
  constexpr double kOff = 0.02;
  return std::ranges::all_of(anatomy.spine, [&](int node) {
    const glm::dvec3 place = origin(character.nodes[static_cast<Index>(node)].world_from_node);
    return std::abs(glm::dot(place - mirror.middle, mirror.left)) <= kOff * anatomy.spine_length;
  });
}

std::vector<int> mirrored_nodes(const Character& character, const Mirror& mirror) {
  std::map<std::tuple<std::string, int, Side>, int> by_name;
  std::vector<NameFacts> facts;
  for (const Node& node : character.nodes) facts.push_back(read_joint_name(node.name));
  for (Index n = 0; n < facts.size(); ++n)
    if (facts[n].side != Side::none)
      by_name.emplace(
          std::tuple(facts[n].without_side, static_cast<int>(facts[n].part), facts[n].side),
          static_cast<int>(n));
  std::vector<int> out(facts.size());
  for (Index n = 0; n < facts.size(); ++n) {
    out[n] = static_cast<int>(n);
    if (facts[n].side != Side::none) {
      const Side other = facts[n].side == Side::left ? Side::right : Side::left;
      const auto found =
          by_name.find({facts[n].without_side, static_cast<int>(facts[n].part), other});
      if (found != by_name.end()) {
        out[n] = found->second;
        continue;
      }
    }
    // No pair by name: the nearest joint to the mirrored place, itself where that is nearest.
    const glm::dvec3 image = mirror(origin(character.nodes[n].world_from_node));
    double nearest = glm::distance(image, origin(character.nodes[n].world_from_node));
    for (const SkinJoint& joint : character.joints) {
      const auto m = static_cast<Index>(joint.node);
      if (facts[m].side != Side::none &&
          (facts[m].side == facts[n].side || facts[n].side == Side::none))
        continue;
      const double distance = glm::distance(image, origin(character.nodes[m].world_from_node));
      if (distance < 0.5 * nearest) {
        nearest = distance;
        out[n] = joint.node;
      }
    }
  }
  return out;
}

}  // namespace backbend::skin
