#include "validate/judge/joint_places.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "validate/metrics/math/median.h"

namespace backbend::validate {
namespace {

using Index = std::size_t;

double aside_of(const glm::dvec3& joint, double fraction, const glm::dvec3& left,
                const BodyMetrics& body) {
  constexpr double kNear = 0.1;
  constexpr Index kMost = 5;
  const SpineSlices& slices = body.slices();
  std::vector<std::pair<double, double>> found;  // how far along the spine, how far aside
  for (Index i = 0; i < slices.slice.size(); ++i) {
    const Slice& slice = slices.slice[i];
    const double off = std::abs(slice.s - fraction);
    if (slice.ring.empty() || off > kNear || slice.spine_share < kSpineSlice) continue;
    if (!slice.line[0].surface || !slice.line[kLineCount / 2].surface) continue;  // an arm's hole
    const glm::dvec3* line = body.rest_slices().line.data() + i * kLineCount;
    const glm::dvec3& normal = body.rest_slices().area[i];
    const glm::dvec3 across = left - normal * (glm::dot(left, normal) / glm::dot(normal, normal));
    const double to_left = glm::dot(line[0] - joint, across),
                 to_right = glm::dot(line[kLineCount / 2] - joint, across);
    if (to_left > to_right) found.emplace_back(off, -(to_left + to_right) / (to_left - to_right));
  }
  std::ranges::sort(found);
  std::vector<double> aside;
  for (Index i = 0; i < std::min(kMost, found.size()); ++i) aside.push_back(found[i].second);
  return aside.empty() ? std::numeric_limits<double>::quiet_NaN() : upper_median(aside);
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
  std::vector<JointPlace> out;
  for (Index k = 1; k <= anatomy.chest_index; ++k)
    out.push_back({anatomy.spine[k],
                   has_left ? aside_of(at(k), fraction[k], anatomy.left, body)
                            : std::numeric_limits<double>::quiet_NaN(),
                   turned_back(k)});
  return out;
}

}  // namespace backbend::validate
