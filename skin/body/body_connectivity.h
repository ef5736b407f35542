#pragma once
#include <array>
#include <vector>

#include "skin/body/body_mesh.h"

namespace backbend::skin {

/// Which faces stand around each vertex of a half body, kept up while the mesh is edited.
///
/// Keeps what a mirrored whole needs: an edge between two vertices on x = 0 is an edge of the
/// border. Removed vertices and faces leave holes until compact().
class Connectivity {
 public:
  explicit Connectivity(HalfMesh& mesh);

  const std::vector<int>& faces(int v) const { return faces_[static_cast<std::size_t>(v)]; }
  /// Neighbours, ascending: the order of every sweep, and so of the result.
  void neighbours(int v, std::vector<int>& out) const;
  int valence(int v) const;

  /// Puts a vertex at `p` on the edge a b; its number.
  int split(int a, int b, const glm::dvec3& p);
  /// Whether moving `a` to `b` keeps the surface a manifold, mirrored too.
  bool may_collapse(int a, int b) const;
  /// The same where neighbours() of `a` are known.
  bool may_collapse(int a, int b, const std::vector<int>& of_a) const;
  void collapse(int a, int b);
  /// Whether the edge a b may become c d, and which they are: (a, b, c) is a face, (b, a, d) too.
  bool may_flip(int a, int b, int* c, int* d) const;
  void flip(int a, int b, int c, int d);
  /// Drops removed vertices and faces; the number that each vertex had before.
  std::vector<int> compact();

 private:
  int third(int face, int a, int b) const;
  void unlink(int v, int face);
  /// The faces with both a and b: at most three are told apart.
  struct Shared {
    int count = 0;
    std::array<int, 3> face{-1, -1, -1};
  };
  Shared shared(int a, int b) const;

  HalfMesh& mesh_;
  std::vector<std::vector<int>> faces_;
  mutable std::vector<int> of_a_, of_b_;  // kept between calls for their memory
};

}  // namespace backbend::skin
