#include "skin/anatomy/mirror_image.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <tuple>

#include "skin/character/joint_names.h"
#include "skin/character/matrix_facts.h"
#include "skin/character/point_cells.h"

namespace backbend::skin {
namespace {

using Index = std::size_t;

constexpr double kAsTheAxis = 0.9994;  // cosine of 2 degrees
constexpr double kTurnedMost = 0.6;    // ... of 53, as far as a body turns from the nearest axis
// Lengths are shares of the points' largest side.
constexpr double kLooksAround = 0.04, kNarrows = 0.7;  // from an image, less with each step
constexpr double kMatches = 0.002, kReaches = 0.005;   // a point and the image of another
constexpr int kSteps = 12;
constexpr std::size_t kMostAsked = 4000;  // points: more fit no better
constexpr double kBetter = 0.05;          // of the points, to leave the skeleton's mirror
constexpr double kInTheMiddle = 0.1;      // of how far a limb reaches to its side

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

/// How many nodes are above both of two nodes, or are one of them.
Index common_nodes(const Character& character, int a, int b) {
  const auto way = [&](int node) {
    std::vector<int> up;
    for (; node >= 0; node = character.nodes[static_cast<Index>(node)].parent) up.push_back(node);
    return up;
  };
  const std::vector<int> of_a = way(a), of_b = way(b);
  const auto [end, unused] = std::mismatch(of_a.rbegin(), of_a.rend(), of_b.rbegin(), of_b.rend());
  return static_cast<Index>(end - of_a.rbegin());
}

/// Of each node that its name puts on one side: the one that is called so on the other, of several
/// the one that moves a skin or not as the node does and hangs nearest to it (a file may have
/// another armature of the same names); -1 for none.
std::vector<int> named_images(const Character& character, const std::vector<NameFacts>& facts) {
  std::map<std::tuple<std::string, int, Side>, std::vector<int>> by_name;
  for (Index n = 0; n < facts.size(); ++n)
    if (facts[n].side != Side::none)
      by_name[{facts[n].without_side, static_cast<int>(facts[n].part), facts[n].side}].push_back(
          static_cast<int>(n));
  std::vector<bool> is_joint(character.nodes.size(), false);
  for (const SkinJoint& joint : character.joints) is_joint[static_cast<Index>(joint.node)] = true;
  std::vector<int> out(character.nodes.size(), -1);
  for (Index n = 0; n < facts.size(); ++n) {
    if (facts[n].side == Side::none) continue;
    const Side other = facts[n].side == Side::left ? Side::right : Side::left;
    const auto found =
        by_name.find({facts[n].without_side, static_cast<int>(facts[n].part), other});
    if (found == by_name.end()) continue;
    out[n] = *std::ranges::max_element(found->second, {}, [&](int image) {
      return std::pair(is_joint[static_cast<Index>(image)] == is_joint[n],
                       common_nodes(character, static_cast<int>(n), image));
    });
  }
  return out;
}

std::vector<NameFacts> read_names(const Character& character) {
  std::vector<NameFacts> facts;
  for (const Node& node : character.nodes) facts.push_back(read_joint_name(node.name));
  return facts;
}

/// The middle between the joints of both limbs of a kind, or where none are, between those that are
/// called left and right, and the way across; nothing without either.
std::optional<Mirror> mirror_of_pairs(const Character& character, const Anatomy& anatomy) {
  glm::dvec3 across(0.0), middle(0.0);
  double pairs = 0.0;
  const auto add = [&](int left, int right) {
    const glm::dvec3 l = origin(character.nodes[static_cast<Index>(left)].world_from_node);
    const glm::dvec3 r = origin(character.nodes[static_cast<Index>(right)].world_from_node);
    across += l - r;
    middle += 0.5 * (l + r);
    pairs += 1.0;
  };
  for (const auto& [left, right] : {std::pair(&anatomy.left_arm, &anatomy.right_arm),
                                    std::pair(&anatomy.left_leg, &anatomy.right_leg)})
    for (Index k = 0; k < std::min(left->size(), right->size()); ++k) add((*left)[k], (*right)[k]);
  if (pairs == 0.0) {
    const std::vector<NameFacts> facts = read_names(character);
    const std::vector<int> image = named_images(character, facts);
    for (const SkinJoint& joint : character.joints) {
      const auto n = static_cast<Index>(joint.node);
      if (facts[n].side == Side::left && image[n] >= 0) add(joint.node, image[n]);
    }
  }
  if (!(glm::length(across) > 0.0)) return std::nullopt;
  return Mirror{glm::normalize(across), middle / pairs};
}

/// Points of a surface, to hold mirrors against.
class SurfaceMatch {
 public:
  SurfaceMatch(const std::vector<glm::dvec3>& points, double size)
      : points_(points), size_(size), near_(points, kMatches * size) {
    const Index step = (points.size() + kMostAsked - 1) / kMostAsked;
    for (Index p = 0; p < points.size(); p += step) asked_.push_back(points[p]);
  }

  /// The share of the points that lie near the image of another.
  double share(const Mirror& mirror) const {
    const auto near = std::ranges::count_if(asked_, [&](const glm::dvec3& point) {
      return near_.nearest(mirror(point)) < near_.size();
    });
    return static_cast<double>(near) / static_cast<double>(asked_.size());
  }

  /// The mirror moved to where points lie half way to those near their images, step by step.
  Mirror fitted(Mirror mirror) const {
    const PointCells cells(points_, kLooksAround * size_);
    double reach = kLooksAround * size_;
    for (int step = 0; step < kSteps;
         ++step, reach = std::max(kNarrows * reach, kReaches * size_)) {
      glm::dvec3 across(0.0), middle(0.0);
      double pairs = 0.0;
      for (const glm::dvec3& point : asked_) {
        const glm::dvec3 image = mirror(point);
        const Index nearest = cells.nearest(image);
        if (nearest == cells.size()) continue;
        const glm::dvec3& other = cells.point(nearest);
        if (glm::distance(other, image) > reach) continue;
        const double side = glm::dot(point - mirror.middle, mirror.left) > 0.0 ? 1.0 : -1.0;
        across += side * (point - other);
        middle += 0.5 * (point + other);
        pairs += 1.0;
      }
      const double length = glm::length(across);
      if (!(length > 0.0)) break;
      mirror = {across / length, middle / pairs};
    }
    return mirror;
  }

 private:
  const std::vector<glm::dvec3>& points_;
  double size_;
  PointCells near_;
  std::vector<glm::dvec3> asked_;
};

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

Mirror surface_mirror(const Character& character, const Anatomy& anatomy,
                      const std::vector<glm::dvec3>& points) {
  const Mirror own = mirror_of(character, anatomy);
  glm::dvec3 low(std::numeric_limits<double>::infinity()), high(-low);
  for (const glm::dvec3& p : points) {
    low = glm::min(low, p);
    high = glm::max(high, p);
  }
  const double size =
      points.empty() ? 0.0 : std::max({high.x - low.x, high.y - low.y, high.z - low.z});
  if (!(size > 0.0)) return own;
  const SurfaceMatch match(points, size);
  Mirror best = own;
  double most = match.share(own) + kBetter;
  if (most >= 1.0) return own;
  const auto try_from = [&](const Mirror& start) {
    const Mirror fitted = match.fitted(start);
    const double share = match.share(fitted);
    if (share <= most) return;
    most = share;
    best = fitted;
  };
  try_from(own);
  if (const auto pairs = mirror_of_pairs(character, anatomy)) try_from(*pairs);
  return best;
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
  const std::vector<NameFacts> facts = read_names(character);
  const std::vector<glm::dvec3> place = places_of(character, mirror);
  std::vector<int> out = named_images(character, facts);
  for (Index n = 0; n < facts.size(); ++n) {
    if (out[n] >= 0) continue;
    out[n] = static_cast<int>(n);
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
