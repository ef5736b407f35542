#pragma once
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "skin/body/body_lanes.h"
#include "skin/body/body_mesh.h"

namespace backbend::skin {

struct Edge {
  int to;
  double cotangent;
};

/// The whole body's edges with half the cotangents of the angles that face them (not below a
/// small positive value: then no weight leaves 0..1).
struct WholeMesh {
  std::vector<glm::dvec3> position;
  std::vector<int> twin;
  std::vector<double> area;
  std::vector<std::vector<Edge>> edges;
};

/// Both halves of a body: the half's vertices first, then the mirror images of those off the plane.
WholeMesh whole_mesh(const HalfMesh& half);

/// Heat on a body's skin: values that spread over a distance of their own at every vertex.
class BodyHeat {
 public:
  /// `reach`: the standard deviation, in metres, to which two steps spread a point.
  BodyHeat(const WholeMesh& whole, const std::vector<double>& reach);
  static constexpr std::size_t kTogether = Lanes::kCount;
  /// Spreads up to kTogether values per vertex in place, each as if alone; the sum over the area
  /// stays, and nothing leaves the range that the values had.
  void spread(std::span<std::vector<double>> values) const;

 private:
  void multiply(const std::vector<Lanes>& x, std::vector<Lanes>& out) const;
  void solve(const std::vector<Lanes>& b, std::vector<Lanes>& x) const;

  // Symmetric matrix in compressed rows, its diagonal apart.
  std::vector<std::size_t> first_;
  std::vector<int> column_;
  std::vector<double> value_, diagonal_, area_;
};

}  // namespace backbend::skin
