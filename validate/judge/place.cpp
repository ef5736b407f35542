#include "validate/judge/place.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace backbend::validate {
namespace {

using Index = std::size_t;

enum Side { kLeft, kRight, kFront, kBack, kSides };
constexpr std::array<const char*, kSides> kSideName = {"left", "right", "front", "back"};
/// A side is named where its value exceeds the others' by this factor.
constexpr double kStandsOut = 1.25;

/// The side that a region of the body has in its name; empty for torso, head and tail.
std::string side_of_region(skin::Region region) {
  switch (region) {
    case skin::Region::arm_left:
    case skin::Region::leg_left:
      return kSideName[kLeft];
    case skin::Region::arm_right:
    case skin::Region::leg_right:
      return kSideName[kRight];
    default:
      return "";
  }
}

/// How far a polyline of three points turns at the middle one, radians; NaN where it has no room.
double turn(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
  const glm::dvec3 in = b - a, out = c - b;
  return std::atan2(glm::length(glm::cross(in, out)), glm::dot(in, out));
}

}  // namespace

PlaceNames::PlaceNames(const skin::Character& character, const skin::Anatomy& anatomy,
                       const BodyMetrics* metrics)
    : character_(character),
      anatomy_(anatomy),
      metrics_(metrics),
      node_region_(skin::node_regions(character, anatomy)) {}

void PlaceNames::name(std::span<const glm::vec3> posed, Finding& finding) const {
  if (finding.slice >= 0) {
    name_slice(posed, finding);
  } else if (finding.vertex >= 0) {
    name_vertex(finding);
  } else if (finding.joint.empty() && (finding.code == "BB020" || finding.code == "BB021")) {
    // Both arms drift together: the place is the left one's root.
    const std::vector<int>& arm =
        anatomy_.left_arm.empty() ? anatomy_.right_arm : anatomy_.left_arm;
    if (!arm.empty()) finding.joint = character_.nodes[static_cast<Index>(arm.front())].name;
  } else if (!finding.joint.empty()) {
    const auto node = std::ranges::find(character_.nodes, finding.joint, &skin::Node::name);
    if (node != character_.nodes.end())
      finding.side =
          side_of_region(node_region_[static_cast<Index>(node - character_.nodes.begin())]);
  }
}

void PlaceNames::name_between(double s, Finding& finding) const {
  const std::vector<std::string>& names = metrics_->spine_names();
  const std::vector<double>& fractions = metrics_->spine_fractions();
  if (names.size() < 2) return;
  const auto above = static_cast<Index>(std::ranges::upper_bound(fractions, s) - fractions.begin());
  const Index i = std::clamp<Index>(above, 1, names.size() - 1);
  finding.between = {names[i - 1], names[i]};
  finding.joint = s - fractions[i - 1] < fractions[i] - s ? names[i - 1] : names[i];
}

void PlaceNames::name_slice(std::span<const glm::vec3> posed, Finding& finding) const {
  if (metrics_ == nullptr) return;
  const std::vector<Slice>& slices = metrics_->slices().slice;
  const auto at = static_cast<Index>(finding.slice);
  if (at >= slices.size()) return;
  const Slice& slice = slices[at];
  name_between(slice.s, finding);
  if (!posed.empty()) finding.side = side_of_slice(posed, finding);
  std::map<std::string, double> share;  // of the ring, by part
  for (Index i = 0; i < slice.ring.size(); ++i) share[part_of(slice.ring[i].a)] += slice.weight[i];
  double most = 0.0;
  for (const auto& [part, weight] : share) {
    if (weight <= most) continue;
    most = weight;
    finding.part = part;
  }
}

std::string PlaceNames::side_of_slice(std::span<const glm::vec3> posed,
                                      const Finding& finding) const {
  const SpineSlices& slices = metrics_->slices();
  const SlicePose pose = pose_slices(slices, posed);
  const SlicePose& rest = metrics_->rest_slices();
  const auto at = static_cast<Index>(finding.slice), reach = static_cast<Index>(metrics_->window());
  if (slices.slice[at].ring.empty()) return "";
  const bool narrows = finding.code == "BB030";
  const bool has_both = at >= reach && at + reach < slices.slice.size() &&
                        !slices.slice[at - reach].ring.empty() &&
                        !slices.slice[at + reach].ring.empty();
  if (!narrows && !has_both) return "";
  std::array<double, kSides> sum{};
  std::array<int, kSides> count{};
  for (Index k = 0; k < static_cast<Index>(kLineCount); ++k) {
    const LinePoint& line = slices.slice[at].line[k];
    if (!line.surface) continue;
    const auto on = [&](const SlicePose& which, Index slice) {
      return which.line[slice * static_cast<Index>(kLineCount) + k];
    };
    double value = 0.0;
    if (narrows) {
      const double before = glm::distance(on(rest, at), rest.centre[at]);
      value = before > 0.0 ? 1.0 - glm::distance(on(pose, at), pose.centre[at]) / before : 0.0;
    } else {
      const auto turned = [&](const SlicePose& which) {
        return turn(on(which, at - reach), on(which, at), on(which, at + reach));
      };
      value = turned(pose) - turned(rest);
    }
    if (!std::isfinite(value)) continue;
    const double left = glm::dot(line.offset, anatomy_.left);
    const double front = glm::dot(line.offset, anatomy_.forward);
    const Side side = std::abs(left) >= std::abs(front) ? (left > 0.0 ? kLeft : kRight)
                                                        : (front > 0.0 ? kFront : kBack);
    sum[side] += std::max(value, 0.0);
    ++count[side];
  }
  for (int side = 0; side < kSides; ++side)
    if (count[side] > 0) sum[side] /= count[side];
  // Left against right says more than front against back, which every bend has.
  for (const auto& [a, b] : {std::pair{kLeft, kRight}, std::pair{kFront, kBack}}) {
    if (count[a] == 0 || count[b] == 0) continue;
    const Side more = sum[a] >= sum[b] ? a : b, less = more == a ? b : a;
    const double others = *std::ranges::max_element(sum);
    if (sum[more] > 0.0 && sum[more] >= kStandsOut * sum[less] && 2.0 * sum[more] >= others)
      return kSideName[more];
  }
  return "";
}

std::string PlaceNames::side_of(const glm::dvec3& offset) const {
  const double left = glm::dot(offset, anatomy_.left);
  const double front = glm::dot(offset, anatomy_.forward);
  if (std::abs(left) >= std::abs(front))
    return left > 0.0 ? kSideName[kLeft] : left < 0.0 ? kSideName[kRight] : "";
  return kSideName[front > 0.0 ? kFront : kBack];
}

void PlaceNames::name_vertex(Finding& finding) const {
  const auto vertex = static_cast<Index>(finding.vertex);
  if (vertex >= character_.vertex_count()) return;
  finding.part = part_of(vertex);
  int node = -1;
  if (vertex < character_.influences.size() && !character_.joints.empty()) {
    const skin::Influences& influences = character_.influences[vertex];
    if (influences.weight[0] > 0.0f && influences.joint[0] < character_.joints.size())
      node = character_.joints[influences.joint[0]].node;
  }
  if (node >= 0) {
    finding.joint = character_.nodes[static_cast<Index>(node)].name;
    finding.side = side_of_region(node_region_[static_cast<Index>(node)]);
  }
  if (metrics_ == nullptr) return;
  const double s = metrics_->coordinate()[vertex];
  const bool on_spine = node < 0 || node_region_[static_cast<Index>(node)] == skin::Region::torso;
  if (std::isfinite(s) && s >= 0.0 && s <= 1.0 && on_spine) {
    name_between(s, finding);
    const std::vector<Slice>& slices = metrics_->slices().slice;
    const auto nearest = std::ranges::min_element(slices, {}, [&](const Slice& slice) {
      return slice.ring.empty() ? 2.0 : std::abs(slice.s - s);
    });
    if (nearest == slices.end() || nearest->ring.empty()) return;
    const glm::dvec3 centre =
        metrics_->rest_slices().centre[static_cast<Index>(nearest - slices.begin())];
    finding.side = side_of(glm::dvec3(metrics_->rest_position()[vertex]) - centre);
  }
}

std::string PlaceNames::part_of(std::size_t vertex) const {
  for (const skin::Part& part : character_.parts)
    if (vertex >= part.first_vertex && vertex < part.first_vertex + part.vertex_count)
      return part.name;
  return "";
}

std::optional<glm::dvec3> PlaceNames::point(std::span<const glm::vec3> posed,
                                            std::span<const glm::dmat4> world_from_node,
                                            const Finding& finding) const {
  const auto vertex = static_cast<Index>(finding.vertex);
  if (finding.vertex >= 0 && vertex < posed.size()) return glm::dvec3(posed[vertex]);
  if (finding.slice >= 0 && metrics_ != nullptr && !posed.empty()) {
    const SlicePose pose = pose_slices(metrics_->slices(), posed);
    const auto at = static_cast<Index>(finding.slice);
    if (at >= pose.centre.size() || std::isnan(pose.centre[at].x)) return std::nullopt;
    const Slice& slice = metrics_->slices().slice[at];
    glm::dvec3 sum(0.0);
    int count = 0;
    for (Index k = 0; k < slice.line.size(); ++k) {
      if (!slice.line[k].surface || side_of(slice.line[k].offset) != finding.side) continue;
      sum += pose.line[at * static_cast<Index>(kLineCount) + k];
      ++count;
    }
    return count > 0 ? sum / static_cast<double>(count) : pose.centre[at];
  }
  const auto node = std::ranges::find(character_.nodes, finding.joint, &skin::Node::name);
  if (finding.joint.empty() || node == character_.nodes.end()) return std::nullopt;
  const auto index = static_cast<Index>(node - character_.nodes.begin());
  if (index >= world_from_node.size()) return std::nullopt;
  return glm::dvec3(world_from_node[index][3]);
}

}  // namespace backbend::validate
