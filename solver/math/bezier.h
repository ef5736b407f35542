#pragma once
#include <array>

namespace backbend::solver {

/// The derivative of a cubic Bezier at t, by t: of one curve (double, glm::dvec3), or over a box of
/// poses (BoxReal, BoxVector).
template <class Real, class Vector>
Vector bezier_derivative(const std::array<Vector, 4>& cv, const Real& t) {
  const Real s = Real(1.0) - t;
  return Real(3.0) * ((s * s) * (cv[1] - cv[0]) + (Real(2.0) * s * t) * (cv[2] - cv[1]) +
                      (t * t) * (cv[3] - cv[2]));
}

}  // namespace backbend::solver
