#include "skin/facing.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

namespace backbend::skin {
namespace {

using Index = std::size_t;

glm::dvec3 at(const SkeletonShape& shape, int node) {
  return shape.position[static_cast<Index>(node)];
}

/// The world axis within 30 degrees of `v`, else `v` itself, unit; zero stays zero.
glm::dvec3 snapped(const glm::dvec3& v) {
  const double length = glm::length(v);
  if (!(length > 0.0)) return glm::dvec3(0.0);
  for (int axis = 0; axis < 3; ++axis) {
    if (std::abs(v[axis]) < 0.866 * length) continue;
    glm::dvec3 out(0.0);
    out[axis] = v[axis] > 0.0 ? 1.0 : -1.0;
    return out;
  }
  return v / length;
}

glm::dvec3 without(const glm::dvec3& v, const glm::dvec3& axis) {
  return v - glm::dot(v, axis) * axis;
}

std::string axis_text(const glm::dvec3& v) {
  for (int axis = 0; axis < 3; ++axis)
    if (std::abs(v[axis]) == 1.0)
      return std::string(v[axis] > 0.0 ? "+" : "-") + static_cast<char>('X' + axis);
  return "an oblique axis";
}

glm::dvec3 find_up(const SkeletonShape& shape, const Anatomy& anatomy, std::string& why) {
  constexpr glm::dvec3 kStandard(0.0, 1.0, 0.0);
  why = "the standard's";
  if (anatomy.left_leg.size() < 2 || anatomy.right_leg.size() < 2) return kStandard;
  // A pair of fins points anywhere.
  if (shape.name[static_cast<Index>(anatomy.left_leg.front())].part == BodyPart::fin)
    return kStandard;
  const glm::dvec3 down = at(shape, anatomy.left_leg.back()) - at(shape, anatomy.left_leg.front()) +
                          at(shape, anatomy.right_leg.back()) -
                          at(shape, anatomy.right_leg.front());
  const glm::dvec3 body = at(shape, anatomy.spine.back()) - at(shape, anatomy.spine.front());
  const glm::dvec3 up = snapped(-down);
  // Someone who sits: the legs point forward, the back does not.
  if (glm::length(up) == 0.0 || (up != kStandard && snapped(body) == kStandard)) return kStandard;
  why = "away from the feet";
  return up;
}

/// Left by the names of pairs, zero where no name tells.
glm::dvec3 left_by_name(const SkeletonShape& shape, const glm::dvec3& up) {
  glm::dvec3 sum(0.0);
  for (const MirrorPair& pair : shape.pairs) {
    if (!pair.named || shape.name[static_cast<Index>(pair.left)].control) continue;
    sum += at(shape, shape.farthest[static_cast<Index>(pair.left)]) -
           at(shape, shape.farthest[static_cast<Index>(pair.right)]);
  }
  const glm::dvec3 level = without(sum, up);
  return glm::length(level) > 0.01 * shape.size ? level : glm::dvec3(0.0);
}

/// The line across two limbs, in either sense.
glm::dvec3 across(const SkeletonShape& shape, const Anatomy& anatomy, const glm::dvec3& up) {
  const auto& left = anatomy.left_arm.empty() ? anatomy.left_leg : anatomy.left_arm;
  const auto& right = anatomy.right_arm.empty() ? anatomy.right_leg : anatomy.right_arm;
  if (left.empty() || right.empty()) return glm::dvec3(0.0);
  return without(at(shape, left.back()) - at(shape, right.back()), up);
}

/// From the ankles to the middle of the soles, in the level plane; zero without legs.
glm::dvec3 sole_direction(const Character& character, const SkeletonShape& shape,
                          const Anatomy& anatomy, const glm::dvec3& up) {
  double floor = std::numeric_limits<double>::infinity(), top = -floor;
  for (const glm::vec3& p : shape.rest) {
    floor = std::min(floor, glm::dot(glm::dvec3(p), up));
    top = std::max(top, glm::dot(glm::dvec3(p), up));
  }
  // Ankles stand at about 4 % of a human's height: below that there is foot alone.
  const double sole_height = floor + 0.035 * (top - floor);
  glm::dvec3 sum(0.0);
  for (const auto* leg : {&anatomy.left_leg, &anatomy.right_leg}) {
    const auto ankle = std::find_if(leg->rbegin(), leg->rend(), [&](int joint) {
      return glm::dot(at(shape, joint), up) > sole_height;
    });
    if (ankle == leg->rend()) return glm::dvec3(0.0);
    glm::dvec3 sole(0.0);
    double count = 0.0;
    for (Index v = 0; v < shape.rest.size(); ++v) {
      const glm::dvec3 p(shape.rest[v]);
      const int joint = character.joints[character.influences[v].joint[0]].node;
      if (glm::dot(p, up) > sole_height || !shape.is_ancestor(character, leg->front(), joint))
        continue;
      sole += p;
      count += 1.0;
    }
    if (count == 0.0) return glm::dvec3(0.0);
    sum += without(sole / count - at(shape, *ankle), up);
  }
  return sum;
}

glm::dvec3 forward_by_body(const Character& character, const SkeletonShape& shape,
                           const Anatomy& anatomy, const glm::dvec3& up, std::string& why) {
  const glm::dvec3 body = at(shape, anatomy.spine.back()) - at(shape, anatomy.spine.front());
  if (glm::length(without(body, up)) > 0.7 * glm::length(body)) {
    why = "from the hips to the head";
    return without(body, up);
  }
  if (!anatomy.left_leg.empty() && !anatomy.right_leg.empty()) {
    const glm::dvec3 soles = sole_direction(character, shape, anatomy, up);
    if (glm::length(soles) > 0.01 * shape.size) {
      why = "from the ankles to the soles";
      return soles;
    }
  }
  why = "the standard's";
  return {0.0, 0.0, 1.0};
}

}  // namespace

void find_facing(const Character& character, const SkeletonShape& shape, Anatomy& anatomy) {
  std::string up_why, forward_why;
  anatomy.up = find_up(shape, anatomy, up_why);
  glm::dvec3 left = left_by_name(shape, anatomy.up);
  if (glm::length(left) > 0.0) {
    forward_why = "left and right by the joints' names";
  } else {
    glm::dvec3 forward =
        snapped(forward_by_body(character, shape, anatomy, anatomy.up, forward_why));
    // The limbs' line is the better measure of the axis, forward of its sense.
    const glm::dvec3 line = across(shape, anatomy, anatomy.up);
    left = glm::cross(anatomy.up, forward);
    if (glm::length(line) > 0.0 && std::abs(glm::dot(glm::normalize(line), left)) > 0.5)
      left = glm::dot(line, left) > 0.0 ? line : -line;
    // Where the standard's forward is up, the limbs' line is all there is.
    if (glm::length(left) == 0.0) left = glm::length(line) > 0.0 ? line : glm::dvec3(1.0, 0.0, 0.0);
  }
  anatomy.left = snapped(glm::normalize(without(snapped(left), anatomy.up)));
  // Adding 0 turns -0 into 0, which would show in reports.
  anatomy.forward = glm::normalize(glm::cross(anatomy.left, anatomy.up)) + 0.0;
  anatomy.reasons.push_back("up " + axis_text(anatomy.up) + ": " + up_why);
  anatomy.reasons.push_back("faces " + axis_text(anatomy.forward) + ": " + forward_why);
}

}  // namespace backbend::skin
