#include "validate/metrics/surface/spine_coordinate.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

namespace backbend::validate {
namespace {

constexpr int kSamples = 128;        // along the line
constexpr double kBlur = 0.2;        // standard deviation of the average, arc fraction
constexpr double kDeviations = 3.0;  // standard deviations that the average looks to either side
constexpr int kBlurSteps = 120;      // of the average
// Beyond this share of the radius of curvature the planes square to the line are about to meet.
constexpr double kSureDepth = 0.8;
constexpr int kMostSweeps = 4000;
constexpr float kSettled = 1e-6f;  // arc fraction; a micrometre of a human spine

/// Point of a polyline at an arc fraction; beyond an end, the polyline turned half round that end,
/// so that averages at the end give the end itself.
class MirroredPolyline {
 public:
  explicit MirroredPolyline(std::span<const glm::dvec3> joint) : joint_(joint), arc_(joint.size()) {
    for (std::size_t i = 1; i < joint.size(); ++i)
      arc_[i] = arc_[i - 1] + glm::distance(joint[i - 1], joint[i]);
  }
  double length() const { return arc_.back(); }
  glm::dvec3 at(double s) const {
    if (s < 0.0) return 2.0 * joint_.front() - at(-s);
    if (s > 1.0) return 2.0 * joint_.back() - at(2.0 - s);
    const double arc = s * arc_.back();
    const auto above = std::upper_bound(arc_.begin() + 1, arc_.end() - 1, arc);
    const std::size_t i = static_cast<std::size_t>(above - arc_.begin());
    return glm::mix(joint_[i - 1], joint_[i], (arc - arc_[i - 1]) / (arc_[i] - arc_[i - 1]));
  }

 private:
  std::span<const glm::dvec3> joint_;
  std::vector<double> arc_;
};

/// Index of the last sample at or below s, such that the next one exists.
std::size_t segment(const std::vector<double>& s, double at) {
  const auto above = std::upper_bound(s.begin() + 1, s.end() - 1, at);
  return static_cast<std::size_t>(above - s.begin()) - 1;
}

/// Neighbours of each place over the torso's edges, packed.
struct PlaceNeighbours {
  std::vector<std::uint32_t> first, other;

  PlaceNeighbours(const RestMesh& mesh) {
    std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;
    for (const glm::uvec3& t : mesh.triangle) {
      if (!mesh.torso[t.x] || !mesh.torso[t.y] || !mesh.torso[t.z]) continue;
      const std::uint32_t p[3] = {mesh.place[t.x], mesh.place[t.y], mesh.place[t.z]};
      for (int i = 0; i < 3; ++i) {
        edges.emplace_back(p[i], p[(i + 1) % 3]);
        edges.emplace_back(p[(i + 1) % 3], p[i]);
      }
    }
    std::ranges::sort(edges);
    edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
    first.assign(mesh.place_count + 1, 0);
    for (const auto& edge : edges) ++first[edge.first + 1];
    for (std::size_t i = 1; i < first.size(); ++i) first[i] += first[i - 1];
    for (const auto& edge : edges) other.push_back(edge.second);
  }
};

}  // namespace

SpineLine::SpineLine(std::span<const glm::dvec3> joint) {
  const MirroredPolyline chain(joint);
  length_ = chain.length();
  for (int i = 0; i <= kSamples; ++i) {
    const double s = static_cast<double>(i) / kSamples;
    glm::dvec3 sum(0.0);
    double weight = 0.0;
    for (int k = -kBlurSteps; k <= kBlurSteps; ++k) {
      const double away = kDeviations * k / kBlurSteps;
      const double w = std::exp(-0.5 * away * away);
      sum += w * chain.at(s + kBlur * away);
      weight += w;
    }
    point_.push_back(sum / weight);
    s_.push_back(s);
  }
  for (std::size_t i = 0; i < point_.size(); ++i)
    tangent_.push_back(
        glm::normalize(point_[std::min(i + 1, point_.size() - 1)] - point_[i == 0 ? 0 : i - 1]));
}

glm::dvec3 SpineLine::point(double s) const {
  if (s < 0.0) return point_.front() + tangent_.front() * (s * length_);
  if (s > 1.0) return point_.back() + tangent_.back() * ((s - 1.0) * length_);
  const std::size_t i = segment(s_, s);
  return glm::mix(point_[i], point_[i + 1], (s - s_[i]) / (s_[i + 1] - s_[i]));
}

glm::dvec3 SpineLine::tangent(double s) const {
  if (s <= 0.0) return tangent_.front();
  if (s >= 1.0) return tangent_.back();
  const std::size_t i = segment(s_, s);
  return glm::normalize(glm::mix(tangent_[i], tangent_[i + 1], (s - s_[i]) / (s_[i + 1] - s_[i])));
}

SpineLine::Foot SpineLine::foot(const glm::dvec3& p) const {
  const std::size_t last = point_.size() - 1;
  std::size_t nearest = 0;
  double best = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i <= last; ++i) {
    const glm::dvec3 gap = p - point_[i];
    if (glm::dot(gap, gap) < best) {
      best = glm::dot(gap, gap);
      nearest = i;
    }
  }
  const auto ahead = [&](std::size_t i) { return glm::dot(p - point_[i], tangent_[i]); };
  const double here = ahead(nearest);
  if (nearest == 0 && here <= 0.0) return {here / length_, true};
  if (nearest == last && here >= 0.0) return {1.0 + here / length_, true};
  const std::size_t low = here >= 0.0 && nearest < last ? nearest : nearest - 1;
  const double before = ahead(low), after = ahead(low + 1);
  // The plane passes the point between two samples unless their planes meet on this side of it.
  const double step = glm::distance(point_[low], point_[low + 1]);
  const bool sure = before - after > (1.0 - kSureDepth) * step;
  const double share =
      before > after ? std::clamp(before / (before - after), 0.0, 1.0) : (here >= 0.0 ? 1.0 : 0.0);
  return {s_[low] + (s_[low + 1] - s_[low]) * share, sure};
}

std::vector<float> spine_coordinate(const RestMesh& mesh, const SpineLine& line) {
  std::vector<float> s(mesh.place_count, std::numeric_limits<float>::quiet_NaN());
  std::vector<std::uint32_t> unsure;
  std::vector<char> is_unsure(mesh.place_count, 0);
  for (std::size_t v = 0; v < mesh.position.size(); ++v) {
    const std::uint32_t place = mesh.place[v];
    if (!mesh.torso[v] || !std::isnan(s[place])) continue;
    const SpineLine::Foot foot = line.foot(glm::dvec3(mesh.position[v]));
    s[place] = static_cast<float>(foot.s);
    if (!foot.sure) {
      unsure.push_back(place);
      is_unsure[place] = 1;
    }
  }
  if (unsure.empty()) return s;

  // The harmonic field by relaxation: few places, fixed order, each the mean of its neighbours.
  const PlaceNeighbours neighbours(mesh);
  for (int sweep = 0; sweep < kMostSweeps; ++sweep) {
    float change = 0.0f;
    for (const std::uint32_t place : unsure) {
      double sum = 0.0;
      std::uint32_t count = 0;
      for (std::uint32_t k = neighbours.first[place]; k < neighbours.first[place + 1]; ++k) {
        sum += s[neighbours.other[k]];
        ++count;
      }
      if (count == 0) continue;
      const float mean = static_cast<float>(sum / count);
      change = std::max(change, std::abs(mean - s[place]));
      s[place] = mean;
    }
    if (change < kSettled) break;
  }
  return s;
}

}  // namespace backbend::validate
