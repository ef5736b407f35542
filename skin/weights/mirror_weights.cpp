#include "skin/weights/mirror_weights.h"

#include <algorithm>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "skin/character/closest_point.h"
#include "skin/character/point_cells.h"

namespace backbend::skin {
namespace {

using Index = std::size_t;

constexpr double kNodeSlack = 0.002;  // of the body's largest side
constexpr double kSurfaceReach = 0.01;

double largest_side(const WeightGraph& graph) {
  glm::dvec3 low(1e300), high(-1e300);
  for (const glm::dvec3& p : graph.position) {
    low = glm::min(low, p);
    high = glm::max(high, p);
  }
  return std::max({high.x - low.x, high.y - low.y, high.z - low.z});
}

/// For each joint the one that stands for it on the other side.
std::vector<std::uint16_t> mirrored_joints(const Character& character, const Mirror& mirror) {
  const std::vector<int> node = mirrored_nodes(character, mirror);
  std::vector<std::uint16_t> out;
  for (Index j = 0; j < character.joints.size(); ++j) {
    const int image = node[static_cast<Index>(character.joints[j].node)];
    const auto found = std::ranges::find(character.joints, image, &SkinJoint::node);
    const bool own = image == character.joints[j].node || found == character.joints.end();
    out.push_back(static_cast<std::uint16_t>(own ? static_cast<std::ptrdiff_t>(j)
                                                 : found - character.joints.begin()));
  }
  return out;
}

}  // namespace

std::vector<JointShares> mirrored_weights(const Character& character, const Mirror& mirror,
                                          const WeightGraph& graph,
                                          const std::vector<JointShares>& weights) {
  const double size = largest_side(graph);
  std::vector<JointShares> out(graph.node_count());
  if (!(size > 0.0)) return out;
  const std::vector<std::uint16_t> joint = mirrored_joints(character, mirror);
  std::vector<std::vector<Index>> triangles(graph.node_count());
  for (Index t = 0; t < character.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) triangles[graph.node[character.triangles[t][k]]].push_back(t);
  double length = 0.0;
  for (std::uint32_t n = 0; n < graph.node_count(); ++n)
    for (const std::uint32_t m : graph.neighbours(n))
      length += glm::distance(graph.position[n], graph.position[m]);
  const double mean = graph.to.empty() ? 0.0 : length / static_cast<double>(graph.to.size());
  const PointCells cells(graph.position, std::max(kNodeSlack * size, mean));
  for (std::uint32_t n = 0; n < graph.node_count(); ++n) {
    const glm::dvec3 at = mirror(graph.position[n]);
    const Index nearest = cells.nearest(at);
    if (nearest == graph.node_count()) continue;
    JointShares there;
    if (glm::distance(graph.position[nearest], at) <= kNodeSlack * size) {
      there = weights[nearest];
    } else {
      TrianglePoint best;
      best.distance = kSurfaceReach * size;
      const glm::uvec3* found = nullptr;
      const auto look_around = [&](std::uint32_t node) {
        for (const Index t : triangles[node]) {
          const glm::uvec3& corner = character.triangles[t];
          const auto corner_at = [&](int k) { return graph.position[graph.node[corner[k]]]; };
          const TrianglePoint on =
              closest_on_triangle(at, corner_at(0), corner_at(1), corner_at(2));
          if (on.distance >= best.distance) continue;
          best = on;
          found = &corner;
        }
      };
      look_around(static_cast<std::uint32_t>(nearest));
      for (const std::uint32_t m : graph.neighbours(static_cast<std::uint32_t>(nearest)))
        look_around(m);
      if (found == nullptr) continue;
      for (int k = 0; k < 3; ++k)
        for (const auto& [j, share] : weights[graph.node[(*found)[k]]])
          there[j] += best.share[static_cast<Index>(k)] * share;
    }
    for (const auto& [j, share] : there) out[n][joint[j]] += share;
  }
  return out;
}

std::vector<std::uint32_t> mirrored_graph_nodes(const Mirror& mirror, const WeightGraph& graph) {
  const double slack = kNodeSlack * largest_side(graph);
  std::vector<std::uint32_t> out(graph.node_count(),
                                 static_cast<std::uint32_t>(graph.node_count()));
  if (!(slack > 0.0)) return out;
  const PointCells cells(graph.position, slack);
  for (Index n = 0; n < graph.node_count(); ++n)
    out[n] = static_cast<std::uint32_t>(cells.nearest(mirror(graph.position[n])));
  return out;
}

}  // namespace backbend::skin
