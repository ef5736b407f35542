#pragma once
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <vector>

#include "solver/curves/curve.h"

namespace backbend::solver {

/// Frames along a path that never roll about it: columns X = up x tangent (the side), Y = up,
/// Z = tangent. `up` at the start is the given one made perpendicular to the tangent, and is then
/// transported, so that no place of the path is special, not even a vertical one.
///
/// Double reflection (W. Wang, B. Juttler, D. Zheng, Y. Liu, "Computation of rotation minimizing
/// frames", ACM TOG 27(1), 2008) over samples 1/64 of a piece apart; the error is of fourth order.
class PathFrames {
 public:
  /// `up_is_lost` is set where `up` is parallel to the path's start: some perpendicular stands in.
  PathFrames(const Curve& path, const glm::dvec3& up);

  struct Place {
    glm::dvec3 position;
    glm::dmat3 frame;
  };
  /// At an arc fraction, clamped to 0..1. Continuous.
  Place at(double fraction) const;
  const Curve& path() const { return path_; }
  bool up_is_lost() const { return up_is_lost_; }

 private:
  struct Sample {
    double arc;
    glm::dvec3 position, tangent, up;
  };
  Curve path_;
  std::vector<Sample> sample_;
  bool up_is_lost_ = false;
};

}  // namespace backbend::solver
