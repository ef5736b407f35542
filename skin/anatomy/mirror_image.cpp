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
constexpr double kInTheMiddle = 0.1;   // of how far a limb reaches to its side

/// Where each node stands to be told from its mirror image: its own place; of one in the middle all
/// of whose joints lie on one side (a clavicle that starts at the spine), the mean of theirs.
std::vector<glm::dvec3> places_of(const Character& character, const Mirror& mirror) {
  struct Limb {
    glm::dvec3 sum{0.0};
    double count = 0.0, left = 0.0, right = 0.0;  // how far it reaches to either side
  };
  std::vector<Limb> limb(character.nodes.size());
  std::vector<glm::dvec3> out;
  for (const Node& node : character.nodes) out.push_back(origin(node.world_from_node));
  for (Index n = 0; n < out.size(); ++n) {
    const double aside = glm::dot(out[n] - mirror.middle, mirror.left);
    for (int above = static_cast<int>(n); above >= 0;
         above = character.nodes[static_cast<Index>(above)].parent) {
      Limb& each = limb[static_cast<Index>(above)];
      each.sum += out[n];
      each.count += 1.0;
      each.left = std::max(each.left, aside);
      each.right = std::max(each.right, -aside);
    }
  }
  for (Index n = 0; n < out.size(); ++n) {
    const Limb& each = limb[n];
    const double reach = std::max(each.left, each.right), back = std::min(each.left, each.right),
                 own = std::abs(glm::dot(out[n] - mirror.middle, mirror.left));
    if (own <= kInTheMiddle * reach && back <= kInTheMiddle * reach && reach > 0.0)
      out[n] = each.sum / each.count;
  }
  return out;
}

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
  const std::vector<glm::dvec3> place = places_of(character, mirror);
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
    const glm::dvec3 image = mirror(place[n]);
    double nearest = glm::distance(image, place[n]);
    for (const SkinJoint& joint : character.joints) {
      const auto m = static_cast<Index>(joint.node);
      if (facts[m].side != Side::none &&
          (facts[m].side == facts[n].side || facts[n].side == Side::none))
        continue;
      const double distance = glm::distance(image, place[m]);
      if (distance < 0.5 * nearest) {
        nearest = distance;
        out[n] = joint.node;
      }
    }
  }
  return out;
}

}  // namespace backbend::skin
