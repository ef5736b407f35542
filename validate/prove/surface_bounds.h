#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "validate/metrics/surface/body_metrics.h"
#include "validate/prove/relative_motions.h"
#include "validate/stage/stage.h"

namespace backbend::validate {

/// Bounds of what linear blending does to a character's surface over boxes of poses.
///
/// A vertex is the sum of rigid motions of points of its own, so a triangle's edges are such
/// sums of vectors, as is the way that it should face (Facing), and whether it does is the same
/// where all of it is moved rigidly: it is asked in the rest space of the motion that carries most
/// of it, in which the other motions hardly move. Weights and rest matrices count as
/// exact; `check` skins in floats, within about 10^-6 of it.
class SurfaceBounds {
 public:
  /// Keeps a reference to the stage's character.
  SurfaceBounds(const Stage& stage, const BodyMetrics& body);

  /// Numbers of the triangles that may turn over at all: those that more than one motion carries.
  /// All others stay as they are at rest.
  std::vector<std::uint32_t> triangles() const;
  /// Numbers of the slices that have a ring.
  std::vector<std::uint32_t> slices() const;

  /// Takes those out of `triangle` that are proved to face as they should, as check BB033 asks it,
  /// at every pose. Returns the share of the surface's rest area that is left in.
  double keep_unproved(const RelativeMotions& motions, std::vector<std::uint32_t>& triangle) const;

  /// The least lower bounds of areas over those at rest; infinite of no slice.
  struct LeastArea {
    double taken_out, left_in;
  };
  /// Takes those out of `slice` whose area is at least `limit` of that at rest at every pose.
  LeastArea keep_small(const RelativeMotions& motions, double limit,
                       std::vector<std::uint32_t>& slice) const;

  /// Which motion each pair of the above needs: for RelativeMotions.
  const std::vector<MotionPair>& pairs() const { return pairs_; }

 private:
  /// What one motion has of a vertex: its weight, the weighted sum of rest places, and what it
  /// makes of the normal as bound of a face with this vertex.
  struct Carried {
    std::uint16_t motion;
    double weight;
    glm::dvec3 place;
    glm::dmat3 face{0.0};
  };
  using Vertex = std::vector<Carried>;
  Vertex vertex_of(std::size_t v) const;

  /// A motion's part in a triangle, about the triangle's middle at rest.
  struct TriangleTerm {
    std::uint16_t pair;
    double weight[2];      // of the edges: differences of weights
    glm::dvec3 edge[2];    // from the first corner to the second and the third
    glm::dvec3 facing[3];  // its part of the way that the triangle should face, by corner
  };
  struct Triangle {
    glm::dvec3 middle;
    std::uint32_t first_term, terms;
    double area;
  };
  /// The vector area of a ring of points r is half the sum of r_p x r_(p + 1). Each point is a sum
  /// of the same few vectors: the three axes, and of each other motion that carries the ring what
  /// its turn does to them and its shift of the ring's middle. So the sum comes to one number for
  /// each two of those vectors, however many points there are.
  struct Ring {
    glm::dvec3 middle;
    std::vector<std::uint16_t> pair;  // of the motions but the base
    std::vector<double> product;      // of vectors a < b, row by row
    double area;                      // at rest
  };

  std::uint16_t pair_of(std::uint16_t base, std::uint16_t motion);
  void add_triangle(const std::array<std::size_t, 3>& vertex, double area);
  void add_ring(const Slice& slice, double area);
  bool faces_as_it_should(const Triangle& t, const RelativeMotions& motions) const;
  double least_area(const Ring& ring, const RelativeMotions& motions) const;

  const skin::Character& character_;
  std::vector<int> motion_of_node_;
  std::vector<glm::dmat4> rest_;  // of each joint: world from mesh
  std::vector<glm::mat3> face_;   // of each joint, at rest: face_turns()
  double area_ = 0.0;
  std::vector<Triangle> triangle_;
  std::vector<TriangleTerm> triangle_term_;
  std::vector<Ring> ring_;
  std::vector<MotionPair> pairs_;
};

}  // namespace backbend::validate
