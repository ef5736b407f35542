#pragma once
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

namespace backbend::validate {

/// Whether two closed triangles have a point in common. Exact for coordinates that are whole
/// multiples of 2^-38 of the largest of them; smaller digits are cut off first, and floats of one
/// body hardly have any. Touching counts; a triangle without area counts as the line or point it is
/// where it pierces the other, and not where it lies in the other's plane.
bool triangles_meet(const glm::vec3 (&a)[3], const glm::vec3 (&b)[3]);

/// Which triangles of a mesh run through each other in a pose and did not at rest. Made once, read
/// by any number of threads.
class SelfIntersection {
 public:
  /// `place`: vertices at one place share a number; triangles that share a place are neighbours and
  /// are never a pair. `group`, one per vertex: vertices with the same number from 0 on move as one
  /// rigid body in every pose, so that nothing new can happen among them; -1: each by itself;
  /// empty: all of them. Keeps copies of what it needs.
  SelfIntersection(std::span<const glm::vec3> rest_position, std::span<const glm::uvec3> triangle,
                   std::span<const std::uint32_t> place, std::span<const int> group = {});

  /// The same mesh, every vertex of which moves by itself.
  SelfIntersection without_groups(std::span<const glm::vec3> rest_position) const;

  /// Numbers of two triangles that meet, the lower first.
  struct Pair {
    std::uint32_t first, second;
    auto operator<=>(const Pair&) const = default;
  };
  /// All pairs of a pose but those inside one group, ascending. Finite positions, one per vertex.
  std::vector<Pair> pairs(std::span<const glm::vec3> position) const;
  /// Those that are not there at rest, but for pairs of two shells that run through each other at
  /// rest already: a collar in a neck, a helmet on a head. A shell is what edges join.
  std::vector<Pair> new_pairs(std::span<const glm::vec3> position) const;

  struct Measures {
    std::size_t pairs = 0;  // new against rest
    double area = 0.0;      // of the triangles in them, share of the whole surface, both at rest
    int vertex = -1;        // a corner of the largest of these triangles
  };
  Measures measure(std::span<const glm::vec3> position) const;

 private:
  struct Node {
    std::uint32_t first = 0, count = 0;  // into order_
    std::uint32_t right = 0;             // child; the left one is the next node; 0: a leaf
    int group = -1;                      // of all its triangles
    std::uint32_t leaf = 0;              // which leaf it is, counted from 0
  };
  /// Triangles of two leaves that share a place: bit 8 i + j for the i-th of one and the j-th of
  /// the other, `leaf`.
  struct Neighbour {
    std::uint32_t leaf = 0;
    std::uint64_t triangles = 0;
  };
  struct Search;
  SelfIntersection() = default;
  void prepare(std::span<const glm::vec3> rest_position);
  void build(std::uint32_t first, std::uint32_t count, const std::vector<glm::vec3>& middle);
  void list_vertices();
  void find_neighbours();
  void find_shells();
  Pair shells_of(const Pair& pair) const;

  std::vector<glm::uvec3> triangle_, places_;  // corners by vertex, and by place
  std::vector<float> area_;                    // at rest
  double whole_area_ = 0.0;
  std::vector<int> group_;            // of each triangle
  std::vector<std::uint32_t> order_;  // triangles as the leaves hold them
  std::vector<Node> node_;            // a tree over order_, parents before children
  std::uint32_t leaves_ = 0;
  std::vector<std::uint32_t> vertex_of_leaf_;   // each once, one leaf after another
  std::vector<std::uint32_t> first_vertex_;     // of each leaf, and one past the last
  std::vector<Neighbour> neighbour_;            // of every leaf, one leaf after another
  std::vector<std::uint32_t> first_neighbour_;  // of each leaf, and one past the last
  std::vector<Pair> rest_pairs_;
  std::vector<std::uint32_t> shell_;  // of each triangle
  std::vector<Pair> joined_shells_;   // that meet at rest, ascending
};

}  // namespace backbend::validate
