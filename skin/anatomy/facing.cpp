#include "skin/anatomy/facing.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <utility>
#include <vector>

#include "skin/character/ancestor.h"
#include "skin/character/printable.h"

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
  const std::string name = axis_name(v);
  return name.empty() ? "an oblique axis" : name;
}

/// The axis called `-Z`. Throws CharacterError for any other name, headed by what it stands for.
glm::dvec3 axis_named(const std::string& name, const Character& character, const char* what) {
  if (std::find(kAxisNames.begin(), kAxisNames.end(), name) == kAxisNames.end())
    throw CharacterError(character.file_name + ": " + what + " " + in_quotes(name) +
                         ": expected +X, -X, +Y, -Y, +Z or -Z");
  glm::dvec3 axis(0.0);
  axis[name.back() - 'X'] = name.front() == '-' ? -1.0 : 1.0;
  return axis;
}

double angle_deg(const glm::dvec3& a, const glm::dvec3& b) {
  return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b)) * 180.0 / 3.14159265358979;
}

// Legs of animals lean, and back and legs of one who sits or steps point elsewhere: only where both
// say the same within this angle does a body stand askew.
constexpr double kSameDirection = 12.0;

/// Which way is up, and whether that is beyond doubt.
struct Up {
  glm::dvec3 axis{0.0, 1.0, 0.0};
  std::string why = "the standard's";
  bool sure = true;
};

/// The lowest and the highest point of the body along a direction.
std::pair<double, double> extent(const SkeletonShape& shape, const glm::dvec3& up) {
  double floor = std::numeric_limits<double>::infinity(), top = -floor;
  for (Index v = 0; v < shape.rest.size(); ++v) {
    if (shape.is_scene[v]) continue;
    const double along = glm::dot(glm::dvec3(shape.rest[v]), up);
    floor = std::min(floor, along);
    top = std::max(top, along);
  }
  return {floor, top};
}

/// How high above the body's lowest point the legs end, as a share of its height.
double legs_end_at(const SkeletonShape& shape, const Anatomy& anatomy, const glm::dvec3& up) {
  const auto [floor, top] = extent(shape, up);
  const double end = std::min(glm::dot(at(shape, anatomy.left_leg.back()), up),
                              glm::dot(at(shape, anatomy.right_leg.back()), up));
  return top > floor ? (end - floor) / (top - floor) : 0.0;
}

/// Whether a body stands on its forelegs, which hang from it as the standard says.
bool stands_on_forelegs(const SkeletonShape& shape, const Anatomy& anatomy,
                        const glm::dvec3& standard) {
  constexpr double kUpright = 30.0;
  glm::dvec3 down(0.0);
  for (const auto* leg : {&anatomy.left_arm, &anatomy.right_arm}) {
    if (leg->size() < 2) return false;
    down += at(shape, leg->back()) - at(shape, leg->front());
  }
  return glm::length(down) > 0.0 && angle_deg(-down, standard) < kUpright;
}

Up find_up(const SkeletonShape& shape, const Anatomy& anatomy) {
  constexpr glm::dvec3 kStandard(0.0, 1.0, 0.0);
  if (anatomy.left_leg.size() < 2 || anatomy.right_leg.size() < 2) return {};
  // A pair of fins points anywhere.
  if (shape.name[static_cast<Index>(anatomy.left_leg.front())].part == BodyPart::fin) return {};
  const glm::dvec3 down = at(shape, anatomy.left_leg.back()) - at(shape, anatomy.left_leg.front()) +
                          at(shape, anatomy.right_leg.back()) -
                          at(shape, anatomy.right_leg.front());
  const glm::dvec3 body = at(shape, anatomy.spine.back()) - at(shape, anatomy.spine.front());
  if (glm::length(down) == 0.0) return {};
  const glm::dvec3 up = snapped(-down);
  if (up == kStandard) return {kStandard, "away from the feet", true};
  // Someone who sits or crouches: the legs point forward, the back does not.
  constexpr double kUprightBack = 50.0;
  const double back = angle_deg(body, kStandard);
  if (back < kUprightBack && back < angle_deg(body, up)) return {};
  const std::string lean =
      number_text(std::round(angle_deg(-down, kStandard)), 3) + " deg from the standard's +Y";
  // Off every axis the legs alone prove nothing; nor do legs that a body would not stand on, as
  // those of an animal whose feet hang elsewhere and whose tail reaches further.
  const bool oblique = (up.x != 0.0) + (up.y != 0.0) + (up.z != 0.0) > 1;
  constexpr double kStandsOn = 0.35;  // knees, of a skeleton without feet, are at 0.28
  const bool off_the_floor = legs_end_at(shape, anatomy, up) > kStandsOn;
  if (off_the_floor || (oblique && angle_deg(-down, body) > kSameDirection))
    return {kStandard, "the standard's; the legs lean " + lean,
            angle_deg(-down, kStandard) < 60.0 || stands_on_forelegs(shape, anatomy, kStandard)};
  return {up, "away from the feet, " + lean, false};
}

/// Left by the names of pairs, zero where no name tells. Off every axis of the world only where all
/// pairs say the same: of a body that takes a step they do not, and the nearest axis counts.
glm::dvec3 left_by_name(const SkeletonShape& shape, const glm::dvec3& up, bool& sure) {
  glm::dvec3 sum(0.0);
  std::vector<glm::dvec3> lines;
  for (const MirrorPair& pair : shape.pairs) {
    if (!pair.named || shape.name[static_cast<Index>(pair.left)].control) continue;
    sum += at(shape, shape.farthest[static_cast<Index>(pair.left)]) -
           at(shape, shape.farthest[static_cast<Index>(pair.right)]);
    const glm::dvec3 line = without(at(shape, pair.left) - at(shape, pair.right), up);
    if (glm::length(line) > 0.01 * shape.size) lines.push_back(line);
  }
  const glm::dvec3 level = without(sum, up);
  if (!(glm::length(level) > 0.01 * shape.size)) return glm::dvec3(0.0);
  const glm::dvec3 axis = snapped(level);
  if (std::abs(axis.x) == 1.0 || std::abs(axis.y) == 1.0 || std::abs(axis.z) == 1.0) return level;
  glm::dvec3 roots(0.0);
  for (const glm::dvec3& line : lines) roots += glm::normalize(line);
  const bool agree = std::all_of(lines.begin(), lines.end(), [&](const glm::dvec3& line) {
    return angle_deg(line, roots) <= kSameDirection;
  });
  if (!lines.empty() && agree) return roots;
  sure = false;
  int most = 0;
  for (int k = 1; k < 3; ++k)
    if (std::abs(level[k]) > std::abs(level[most])) most = k;
  glm::dvec3 nearest(0.0);
  nearest[most] = level[most] > 0.0 ? 1.0 : -1.0;
  return nearest;
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
  const auto [floor, top] = extent(shape, up);
  // Ankles stand at about 4 % of a human's height: below that there is foot alone.
  const double sole_height = floor + 0.035 * (top - floor);
  glm::dvec3 sum(0.0);
  for (const auto* leg : {&anatomy.left_leg, &anatomy.right_leg}) {
    if (leg->size() < 2) return glm::dvec3(0.0);  // no ankle
    const auto ankle = std::find_if(leg->rbegin(), leg->rend(), [&](int joint) {
      return glm::dot(at(shape, joint), up) > sole_height;
    });
    if (ankle == leg->rend()) return glm::dvec3(0.0);
    glm::dvec3 sole(0.0);
    double count = 0.0;
    for (Index v = 0; v < shape.rest.size(); ++v) {
      const glm::dvec3 p(shape.rest[v]);
      const int joint = character.joints[character.influences[v].joint[0]].node;
      if (glm::dot(p, up) > sole_height || !is_ancestor(character, leg->front(), joint)) continue;
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

/// Left by what the character shows: names of joints first, then the body. `sure` turns false where
/// pairs of joints disagree.
glm::dvec3 find_left(const Character& character, const SkeletonShape& shape, const Anatomy& anatomy,
                     bool& sure, std::string& why) {
  glm::dvec3 left = left_by_name(shape, anatomy.up, sure);
  if (glm::length(left) > 0.0) {
    why = sure ? "left and right by the joints' names"
               : "the nearest axis; pairs of joints point different ways";
    return left;
  }
  const glm::dvec3 forward = snapped(forward_by_body(character, shape, anatomy, anatomy.up, why));
  // The limbs' line is the better measure of the axis, forward of its sense.
  const glm::dvec3 line = across(shape, anatomy, anatomy.up);
  left = glm::cross(anatomy.up, forward);
  if (glm::length(line) > 0.0 && std::abs(glm::dot(glm::normalize(line), left)) > 0.5)
    left = glm::dot(line, left) > 0.0 ? line : -line;
  // Where the standard's forward is up, the limbs' line is all there is.
  if (glm::length(left) == 0.0) left = glm::length(line) > 0.0 ? line : glm::dvec3(1.0, 0.0, 0.0);
  return left;
}

}  // namespace

std::string axis_name(const glm::dvec3& direction) {
  for (int axis = 0; axis < 3; ++axis)
    if (std::abs(direction[axis]) > 0.999)
      return std::string(direction[axis] > 0.0 ? "+" : "-") + static_cast<char>('X' + axis);
  return "";
}

void find_facing(const Character& character, const SkeletonShape& shape, const AnatomyHints& hints,
                 Anatomy& anatomy) {
  Up up = find_up(shape, anatomy);
  if (!up.sure && hints.confirmed && !hints.confirmed_up.empty())
    up = {axis_named(hints.confirmed_up, character, "up"), "as confirmed", true};
  anatomy.found_up = up.axis;
  if (!hints.up.empty())
    up = {axis_named(hints.up, character, "up"), "as specified", true};
  else if (!up.sure && !hints.confirmed)
    anatomy.doubts.push_back("up is " + axis_text(up.axis) + ": " + up.why);
  anatomy.up = up.axis;

  bool names_agree = true;
  std::string why;
  const auto forward_of = [&] {
    // Adding 0 turns -0 into 0, which would show in reports.
    return glm::normalize(glm::cross(anatomy.left, anatomy.up)) + 0.0;
  };
  const auto face = [&](const std::string& axis, const char* reason) {
    const glm::dvec3 left = glm::cross(anatomy.up, axis_named(axis, character, "forward"));
    if (glm::length(left) < 0.5) return false;
    anatomy.left = snapped(left);
    anatomy.forward = forward_of();
    why = reason;
    return true;
  };
  const glm::dvec3 left = find_left(character, shape, anatomy, names_agree, why);
  anatomy.left = snapped(glm::normalize(without(snapped(left), anatomy.up)));
  anatomy.forward = forward_of();
  if (!names_agree && hints.confirmed && !hints.confirmed_forward.empty())
    face(hints.confirmed_forward, "as confirmed");
  anatomy.found_forward = anatomy.forward;
  if (!hints.forward.empty()) {
    if (!face(hints.forward, "as specified"))
      throw CharacterError(character.file_name + ": forward " + hints.forward + " is along up " +
                           axis_text(anatomy.up));
  } else if (!names_agree && !hints.confirmed) {
    anatomy.doubts.emplace_back("which way it faces: pairs of joints point different ways");
  }
  anatomy.reasons.push_back("up " + axis_text(anatomy.up) + ": " + up.why);
  anatomy.reasons.push_back("faces " + axis_text(anatomy.forward) + ": " + why);
}

}  // namespace backbend::skin
