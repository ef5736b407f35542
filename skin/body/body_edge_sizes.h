#pragma once
#include <glm/vec3.hpp>
#include <vector>

#include "skin/body/body_mesh.h"
#include "skin/body/body_shape.h"

namespace backbend::skin {

/// Edge lengths that a mesh should have: smaller where the surface bends more, changing slowly.
///
/// Measured on a fine mesh, asked for at any place near it.
class EdgeSizes {
 public:
  /// `finest` and `coarsest` bound the edge length against that of the median curvature. Scaled so
  /// that a mesh of `vertices` (of the half) fits.
  EdgeSizes(const HalfMesh& fine, const BodyShape& shape, double cell, double finest,
            double coarsest, double vertices);
  double at(const glm::dvec3& p) const;
  void scale(double factor) { factor_ *= factor; }

 private:
  glm::ivec3 bucket(const glm::dvec3& p) const;
  /// At least how far `x` is from the buckets with number `b` on its axis, squared.
  double square_apart(double x, int b) const;

  double width_, factor_ = 1.0;
  glm::ivec3 low_{0}, count_{0};
  std::vector<glm::dvec3> place_;
  std::vector<double> size_;
  std::vector<int> first_;  // of each bucket, into place_
};

}  // namespace backbend::skin
