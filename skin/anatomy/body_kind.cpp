#include "skin/anatomy/body_kind.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

namespace backbend::skin {
namespace {

/// Further than this from upright a back lies: people stand within 20 degrees, four-legged bodies
/// beyond 60.
constexpr double kUpright_deg = 45.0;

/// Of the way hips to head: an alpaca's neck takes 0.45, a dog's less than a third.
constexpr double kLongNeck = 0.4;

glm::dvec3 place_of(const Character& character, int node) {
  return glm::dvec3(character.nodes[static_cast<std::size_t>(node)].world_from_node[3]);
}

std::string whole(double value) { return std::to_string(std::lround(value)); }

}  // namespace

std::string_view name_of(BodyKind kind) {
  switch (kind) {
    case BodyKind::human:
      return "human";
    case BodyKind::animal:
      return "animal";
    case BodyKind::long_neck:
      return "long_neck";
    case BodyKind::snake:
      return "snake";
  }
  return "human";
}

BodyKindChoice body_kind(const Character& character, const Anatomy& anatomy) {
  const bool arms = !anatomy.left_arm.empty() || !anatomy.right_arm.empty();
  const bool legs = !anatomy.left_leg.empty() || !anatomy.right_leg.empty();
  if (!arms && !legs) return {BodyKind::snake, "no arms and no legs"};

  double back = 0.0, neck = 0.0;
  for (std::size_t i = 1; i < anatomy.spine.size(); ++i) {
    const double bone = glm::distance(place_of(character, anatomy.spine[i - 1]),
                                      place_of(character, anatomy.spine[i]));
    (i <= anatomy.chest_index ? back : neck) += bone;
  }
  const glm::dvec3 along = place_of(character, anatomy.spine[anatomy.chest_index]) -
                           place_of(character, anatomy.spine.front());
  const double length = glm::length(along);
  const double lean =
      length > 0.0
          ? glm::degrees(std::acos(std::clamp(glm::dot(along, anatomy.up) / length, -1.0, 1.0)))
          : 0.0;
  if (lean <= kUpright_deg)
    return {BodyKind::human,
            arms ? "arms on an upright spine, which leans by " + whole(lean) + " deg"
                 : "an upright spine, which leans by " + whole(lean) + " deg"};
  const double share = neck / std::max(back + neck, 1e-12);
  const std::string lies = "the back leans by " + whole(lean) + " deg from upright, the neck is " +
                           whole(100.0 * share) + " % of the way from hips to head";
  return {share > kLongNeck ? BodyKind::long_neck : BodyKind::animal, lies};
}

}  // namespace backbend::skin
