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

/// The point of a cubic Bezier at t, over a box of poses.
template <class Real, class Vector>
Vector bezier_point(const std::array<Vector, 4>& cv, const Real& t) {
  const Real s = Real(1.0) - t;
  return (s * s * s) * cv[0] + (Real(3.0) * s * s * t) * cv[1] + (Real(3.0) * s * t * t) * cv[2] +
         (t * t * t) * cv[3];
}

/// The chord of a cubic Bezier from u to v over v - u: the mean of the derivative between them. Of
/// one curve, or over a box of poses, where the difference of two points would be far wider.
template <class Real, class Vector>
Vector bezier_chord(const std::array<Vector, 4>& cv, const Real& u, const Real& v) {
  const Real last = u * u + u * v + v * v, sum = u + v;
  return (Real(3.0) - Real(3.0) * sum + last) * (cv[1] - cv[0]) +
         (Real(3.0) * sum - Real(2.0) * last) * (cv[2] - cv[1]) + last * (cv[3] - cv[2]);
}

}  // namespace backbend::solver
