#include "skin/weights/weight_graph.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace backbend::skin {
namespace {

using Index = std::size_t;

constexpr double kSameWeights = 0.01;
constexpr double kCrumb = 0.001;
// Below it a weight between two nodes could leave 0..1, as with the proxy bodies' heat.
constexpr double kLeastCotangent = 0.02;

/// One node for the vertices of a place whose weights are alike.
void number_nodes(const Character& character, WeightGraph& graph) {
  std::vector<std::vector<std::uint32_t>> of_place(character.place_count);
  for (Index v = 0; v < character.vertex_count(); ++v) {
    const JointShares own = shares_of(character.influences[v]);
    auto& known = of_place[character.place[v]];
    const auto same = std::find_if(known.begin(), known.end(), [&](std::uint32_t n) {
      return share_moved(own, shares_of(character.influences[graph.vertex[n]])) < kSameWeights;
    });
    if (same != known.end()) {
      graph.node.push_back(*same);
      continue;
    }
    known.push_back(static_cast<std::uint32_t>(graph.vertex.size()));
    graph.node.push_back(known.back());
    graph.vertex.push_back(static_cast<std::uint32_t>(v));
  }
}

}  // namespace

JointShares shares_of(const Influences& influences) {
  JointShares out;
  for (Index k = 0; k < kMaxInfluences && influences.weight[k] > 0.0f; ++k)
    out[influences.joint[k]] += influences.weight[k];
  return out;
}

Influences influences_of(const JointShares& shares, std::size_t most) {
  std::vector<std::pair<std::uint16_t, double>> order;
  for (const auto& each : shares)
    if (each.second >= kCrumb) order.push_back(each);
  std::stable_sort(order.begin(), order.end(),
                   [](const auto& a, const auto& b) { return a.second > b.second; });
  order.resize(std::min({order.size(), most, static_cast<Index>(kMaxInfluences)}));
  double sum = 0.0;
  for (const auto& each : order) sum += each.second;
  Influences out;
  for (Index k = 0; k < order.size(); ++k) {
    out.joint[k] = order[k].first;
    out.weight[k] = static_cast<float>(order[k].second / sum);
  }
  return out;
}

double share_moved(const JointShares& a, const JointShares& b) {
  double sum = 0.0;
  auto i = a.begin(), j = b.begin();
  while (i != a.end() || j != b.end()) {
    if (j == b.end() || (i != a.end() && i->first < j->first))
      sum += std::abs((i++)->second);
    else if (i == a.end() || j->first < i->first)
      sum += std::abs((j++)->second);
    else
      sum += std::abs((i++)->second - (j++)->second);
  }
  return 0.5 * sum;
}

WeightGraph weight_graph(const Character& character, std::span<const glm::vec3> rest) {
  WeightGraph graph;
  number_nodes(character, graph);
  for (const std::uint32_t v : graph.vertex) graph.position.emplace_back(rest[v]);
  graph.area.assign(graph.vertex.size(), 0.0);
  struct Edge {
    std::uint32_t from, to;
    double cotangent;
  };
  std::vector<Edge> edges;
  double all = 0.0;
  for (const glm::uvec3& t : character.triangles)
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t a = graph.node[t[k]], b = graph.node[t[(k + 1) % 3]],
                          c = graph.node[t[(k + 2) % 3]];
      const glm::dvec3 p = graph.position[a] - graph.position[c];
      const glm::dvec3 q = graph.position[b] - graph.position[c];
      const double doubled = glm::length(glm::cross(p, q));
      graph.area[c] += doubled / 6.0;
      all += doubled / 6.0;
      if (a == b) continue;
      const double cotangent = doubled > 0.0 ? 0.5 * glm::dot(p, q) / doubled : 0.0;
      edges.push_back({a, b, cotangent});
      edges.push_back({b, a, cotangent});
    }
  // Degenerate triangles must not leave a node without any.
  const double least = 1e-3 * all / static_cast<double>(std::max<Index>(1, graph.vertex.size()));
  for (double& area : graph.area) area = std::max({area, least, 1e-300});
  std::stable_sort(edges.begin(), edges.end(), [](const Edge& x, const Edge& y) {
    return x.from != y.from ? x.from < y.from : x.to < y.to;
  });
  graph.first_edge.assign(graph.vertex.size() + 1, 0);
  for (Index i = 0; i < edges.size();) {
    double sum = 0.0;
    Index next = i;
    for (;
         next < edges.size() && edges[next].from == edges[i].from && edges[next].to == edges[i].to;
         ++next)
      sum += edges[next].cotangent;
    graph.to.push_back(edges[i].to);
    graph.cotangent.push_back(std::clamp(sum, kLeastCotangent, 1.0 / kLeastCotangent));
    ++graph.first_edge[edges[i].from + 1];
    i = next;
  }
  for (Index n = 0; n < graph.vertex.size(); ++n) graph.first_edge[n + 1] += graph.first_edge[n];
  return graph;
}

}  // namespace backbend::skin
