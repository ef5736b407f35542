#pragma once
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <map>
#include <span>
#include <vector>

#include "skin/character/character.h"

namespace backbend::skin {

/// A vertex's weights while they are being changed: share by number in Character::joints.
using JointShares = std::map<std::uint16_t, double>;

JointShares shares_of(const Influences& influences);

/// The `most` largest (ties: the smaller number first) without crumbs below 0.1 %, summing to 1.
/// Zeros where there is none.
Influences influences_of(const JointShares& shares, std::size_t most);

/// Half the sum of the differences: the share of a vertex's weight that changes hands, 0..1.
double share_moved(const JointShares& a, const JointShares& b);

/// A character's surface as a graph for fields over it. Vertices at one rest place with the same
/// weights (within 1 %) are one node: seams of normals and texture coordinates do not cut it, parts
/// that only touch are not joined.
struct WeightGraph {
  std::vector<std::uint32_t> node;      // of each vertex
  std::vector<std::uint32_t> vertex;    // the first vertex of each node
  std::vector<glm::dvec3> position;     // of each node, world space at rest
  std::vector<double> area;             // a third of the triangles around each node, above 0
  std::vector<std::size_t> first_edge;  // of each node, and one past the last
  std::vector<std::uint32_t> to;        // of each edge: the neighbour, ascending
  std::vector<double> cotangent;  // of each edge: half the cotangents facing it, 0.02 at least

  std::size_t node_count() const { return vertex.size(); }
  std::span<const std::uint32_t> neighbours(std::uint32_t n) const {
    return std::span(to).subspan(first_edge[n], first_edge[n + 1] - first_edge[n]);
  }
};

/// `rest` has one world-space point a vertex.
WeightGraph weight_graph(const Character& character, std::span<const glm::vec3> rest);

}  // namespace backbend::skin
