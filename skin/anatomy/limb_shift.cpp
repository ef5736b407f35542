#include "skin/anatomy/limb_shift.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <limits>
#include <set>
#include <vector>

#include "skin/deform/skinning.h"

namespace backbend::skin {
namespace {

using Index = std::size_t;

constexpr double kShortest = 0.06;  // of the height: a shorter bone says little of its direction
constexpr double kAgreed = 0.6;     // share of the squared offsets that one shift explains
constexpr double kAcross = 0.5;     // of the shift, across a bone that is to show it
constexpr double kAlong = 0.3;      // of the shift, along a bone that shows it
constexpr double kMostAlong = 0.5;  // ... of the length of those that lie along it
constexpr float kOwn = 0.5f;        // weight from which on a vertex is the bone's own
constexpr Index kFewest = 6;        // places of its own: fewer need not lie around the bone

struct LimbBone {
  int node = -1;
  glm::dvec3 middle{0.0}, along{0.0};
  double length = 0.0;
  double weight = 0.0;
  glm::dvec3 sum{0.0};                 // of what it moves, times weight
  std::vector<glm::dvec3> own;         // points that it moves most
  std::set<std::uint32_t> own_places;  // the first of them

  glm::dvec3 across(const glm::dvec3& v) const { return v - glm::dot(v, along) * along; }
  glm::dvec3 offset() const { return across(sum / weight - middle); }
};

std::vector<LimbBone> bones_of_limbs(const Character& character, const Anatomy& anatomy) {
  std::vector<LimbBone> bones;
  std::vector<int> bone_of(character.nodes.size(), -1);
  const auto at = [&](int node) {
    return glm::dvec3(character.nodes[static_cast<Index>(node)].world_from_node[3]);
  };
  for (const std::vector<int>* limb :
       {&anatomy.left_arm, &anatomy.right_arm, &anatomy.left_leg, &anatomy.right_leg})
    for (Index k = 0; k + 1 < limb->size(); ++k) {
      const glm::dvec3 from = at((*limb)[k]), to = at((*limb)[k + 1]);
      const double length = glm::distance(from, to);
      if (!(length > kShortest * anatomy.height)) continue;
      bone_of[static_cast<Index>((*limb)[k])] = static_cast<int>(bones.size());
      LimbBone bone;
      bone.node = (*limb)[k];
      bone.middle = 0.5 * (from + to);
      bone.along = (to - from) / length;
      bone.length = length;
      bones.push_back(std::move(bone));
    }
  const PosedMesh rest = rest_mesh(character);
  for (Index v = 0; v < character.vertex_count(); ++v) {
    const Influences& influences = character.influences[v];
    for (Index k = 0; k < kMaxInfluences && influences.weight[k] > 0.0f; ++k) {
      const int b = bone_of[static_cast<Index>(character.joints[influences.joint[k]].node)];
      if (b < 0) continue;
      LimbBone& bone = bones[static_cast<Index>(b)];
      const glm::dvec3 p(rest.position[v]);
      bone.weight += influences.weight[k];
      bone.sum += static_cast<double>(influences.weight[k]) * p;
      if (influences.weight[k] < kOwn) continue;
      bone.own.push_back(p);
      if (bone.own_places.size() < kFewest) bone.own_places.insert(character.place[v]);
    }
  }
  std::erase_if(bones, [](const LimbBone& bone) { return bone.own_places.size() < kFewest; });
  return bones;
}

}  // namespace

std::optional<LimbShift> find_limb_shift(const Character& character, const Anatomy& anatomy) {
  const std::vector<LimbBone> bones = bones_of_limbs(character, anatomy);
  glm::dmat3 normal(0.0);
  glm::dvec3 right_side(0.0);
  double length = 0.0;
  for (const LimbBone& bone : bones) {
    normal += bone.length * (glm::dmat3(1.0) - glm::outerProduct(bone.along, bone.along));
    right_side += bone.length * bone.offset();
    length += bone.length;
  }
  if (bones.empty() || !(glm::determinant(normal) > 1e-3 * length * length * length))
    return std::nullopt;
  LimbShift out;
  out.shift = glm::inverse(normal) * right_side;
  double left = 0.0, all = 0.0;
  for (const LimbBone& bone : bones) {
    const glm::dvec3 offset = bone.offset(), rest = offset - bone.across(out.shift);
    left += bone.length * glm::dot(rest, rest);
    all += bone.length * glm::dot(offset, offset);
  }
  if (!(left <= (1.0 - kAgreed) * all)) return std::nullopt;

  double lie_along = 0.0, show_along = 0.0;
  for (const LimbBone& bone : bones) {
    const double along = glm::dot(bone.along, out.shift);
    if (glm::length(bone.across(out.shift)) >= kAcross * glm::length(out.shift)) continue;
    lie_along += bone.length;
    if (glm::dot(bone.sum / bone.weight - bone.middle, bone.along) / along >= kAlong)
      show_along += bone.length;
  }
  if (show_along < kMostAlong * lie_along) return std::nullopt;

  struct Seen {
    double beside, length;
  };
  std::vector<Seen> seen;
  double worst = -std::numeric_limits<double>::infinity(), shown = 0.0;
  for (const LimbBone& bone : bones) {
    const glm::dvec3 shift = bone.across(out.shift);
    if (glm::length(shift) < kAcross * glm::length(out.shift)) continue;
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const glm::dvec3& p : bone.own) {
      const double off = glm::dot(p - bone.middle, shift) / glm::length(shift);
      low = std::min(low, off);
      high = std::max(high, off);
    }
    if (!(high > low)) continue;
    const double beside = (high + low) / (high - low);
    seen.push_back({beside, bone.length});
    shown += bone.length;
    if (beside <= worst) continue;
    worst = beside;
    out.node = bone.node;
  }
  if (seen.empty()) return std::nullopt;
  std::ranges::sort(seen, {}, &Seen::beside);
  double below = 0.0;
  for (const Seen& each : seen) {
    below += each.length;
    out.beside = each.beside;
    if (below >= 0.5 * shown) break;
  }
  return out;
}

}  // namespace backbend::skin
