#include "validate/judge/joint_places.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/geometric.hpp>

#include "skin/anatomy/body_kind.h"
#include "validate/metrics/math/median.h"
#include "validate/metrics/math/nan.h"

namespace backbend::validate {
namespace {

using Index = std::size_t;

/// The median of what the slices near a joint say, those left out that say nothing.
double near_joint(double fraction, const SpineSlices& slices,
                  const std::function<double(Index)>& reading) {
  constexpr double kNear = 0.1;
  constexpr Index kMost = 5;
  std::vector<std::pair<double, double>> found;  // how far along the spine, what is read there
  for (Index i = 0; i < slices.slice.size(); ++i) {
    const double off = std::abs(slices.slice[i].s - fraction);
    if (off > kNear) continue;
    const double value = reading(i);
    if (!std::isnan(value)) found.emplace_back(off, value);
  }
  std::ranges::sort(found);
  std::vector<double> nearest;
  for (Index i = 0; i < std::min(kMost, found.size()); ++i) nearest.push_back(found[i].second);
  return nearest.empty() ? kNan : upper_median(nearest);
}

double aside_of(const glm::dvec3& joint, double fraction, const glm::dvec3& left,
                const BodyMetrics& body) {
  return near_joint(fraction, body.slices(), [&](Index i) {
    const Slice& slice = body.slices().slice[i];
    if (slice.ring.empty() || slice.is_half || slice.spine_share < kSpineSlice) return kNan;
    if (!slice.line[0].surface || !slice.line[kLineCount / 2].surface)
      return kNan;  // an arm's hole
    const glm::dvec3* line = body.rest_slices().line.data() + i * kLineCount;
    const glm::dvec3& normal = body.rest_slices().area[i];
    const glm::dvec3 across = left - normal * (glm::dot(left, normal) / glm::dot(normal, normal));
    const double to_left = glm::dot(line[0] - joint, across),
                 to_right = glm::dot(line[kLineCount / 2] - joint, across);
    return to_left > to_right ? -(to_left + to_right) / (to_left - to_right) : kNan;
  });
}

/// Of each node: whether it moves a vertex, or something that hangs from it does.
std::vector<bool> nodes_that_move(const skin::Character& character) {
  std::vector<bool> moves(character.nodes.size(), false);
  for (const skin::Influences& influences : character.influences)
    for (Index k = 0; k < skin::kMaxInfluences && influences.weight[k] > 0.0f; ++k)
      moves[static_cast<Index>(character.joints[influences.joint[k]].node)] = true;
  for (Index n = moves.size(); n-- > 0;)  // parents stand first
    if (const int parent = character.nodes[n].parent; moves[n] && parent >= 0)
      moves[static_cast<Index>(parent)] = true;
  return moves;
}

double outside_of(double fraction, const BodyMetrics& body) {
  return near_joint(fraction, body.slices(),
                    [&](Index i) { return body.slices().slice[i].outside; });
}

/// Whether a human figure is of bones: between ribs and pelvis only its column is there, which
/// controls of a human's proportions stand in front of. A fish is as thin with all its flesh.
bool is_bony(const Stage& stage, const SpineSlices& slices) {
  if (skin::body_kind(stage.character(), stage.anatomy()).kind != skin::BodyKind::human)
    return false;
  constexpr double kColumn = 0.12;  // of the spine's length: a column's radius
  constexpr double kShare = 0.15;   // of the slices
  const auto columns = std::ranges::count_if(slices.slice, [&](const Slice& slice) {
    return slice.outside > 0.0 && slice.beside_radius < kColumn * slices.spine_length;
  });
  return static_cast<double>(columns) > kShare * static_cast<double>(slices.slice.size());
}

}  // namespace

std::vector<JointPlace> joint_places(const Stage& stage, const BodyMetrics& body) {
  const skin::Anatomy& anatomy = stage.anatomy();
  const auto at = [&](Index k) {
    const auto node = static_cast<Index>(anatomy.spine[k]);
    return glm::dvec3(stage.character().nodes[node].world_from_node[3]);
  };
  const auto turned_back = [&](Index k) {
    if (k < 2 || k == anatomy.chest_index) return 0.0;
    const glm::dvec3 below = at(k) - at(k - 1), above = at(k + 1) - at(k);
    const double shorter = std::min(glm::length(below), glm::length(above));
    return glm::dot(below, above) <= -0.5 * glm::length(below) * glm::length(above)
               ? shorter / anatomy.spine_length
               : 0.0;
  };
  const std::vector<double>& fraction = stage.driver().joint_fractions();
  const auto has_both = [](const std::vector<int>& left, const std::vector<int>& right) {
    return !left.empty() && !right.empty();
  };
  const bool has_left = has_both(anatomy.left_arm, anatomy.right_arm) ||
                        has_both(anatomy.left_leg, anatomy.right_leg);
  // The end of a chain may lie beyond a fish's tail: it moves nothing.
  std::vector<bool> asked = nodes_that_move(stage.character());
  if (is_bony(stage, body.slices())) asked.assign(asked.size(), false);
  std::vector<JointPlace> out;
  for (Index k = 1; k <= anatomy.chest_index; ++k)
    out.push_back(
        {anatomy.spine[k], has_left ? aside_of(at(k), fraction[k], anatomy.left, body) : kNan,
         asked[static_cast<Index>(anatomy.spine[k])] ? outside_of(fraction[k], body) : kNan,
         turned_back(k)});
  return out;
}

}  // namespace backbend::validate
