#pragma once
#include <algorithm>
#include <cmath>
#include <glm/gtc/quaternion.hpp>
#include <glm/mat4x4.hpp>

namespace backbend::skin {

/// Whether every element is a finite number.
inline bool is_finite(const glm::dmat4& matrix) {
  for (int c = 0; c < 4; ++c)
    for (int r = 0; r < 4; ++r)
      if (!std::isfinite(matrix[c][r])) return false;
  return true;
}

/// The length of the longest axis of the 3x3 part.
inline double longest_axis(const glm::dmat4& matrix) {
  const glm::dmat3 axes(matrix);
  return std::max({glm::length(axes[0]), glm::length(axes[1]), glm::length(axes[2])});
}

/// Whether the 3x3 part can be inverted without losing everything: its volume against the cube of
/// its longest axis, so that scale does not matter.
inline bool is_invertible(const glm::dmat4& matrix) {
  const double longest = longest_axis(matrix);
  return std::isfinite(longest) && longest > 0.0 &&
         std::abs(glm::determinant(glm::dmat3(matrix))) > 1e-9 * longest * longest * longest;
}

/// The origin of a frame in the space that its matrix leads to.
inline glm::dvec3 origin(const glm::dmat4& matrix) { return glm::dvec3(matrix[3]); }

/// The rigid motion `turn` about `rest_origin`, which goes to `posed_origin`, as a matrix.
inline glm::dmat4 rigid_matrix(const glm::dquat& turn, const glm::dvec3& rest_origin,
                               const glm::dvec3& posed_origin) {
  glm::dmat4 matrix(glm::mat3_cast(turn));
  matrix[3] = glm::dvec4(posed_origin - glm::dmat3(matrix) * rest_origin, 1.0);
  return matrix;
}

/// Whether two motions are the same within `tolerance`: of their axes, and of their shifts in
/// lengths of `size`.
inline bool same_motion(const glm::dmat4& a, const glm::dmat4& b, double tolerance, double size) {
  double turn = 0.0, shift = 0.0;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) turn = std::max(turn, std::abs(a[c][r] - b[c][r]));
    shift = std::max(shift, std::abs(a[3][r] - b[3][r]));
  }
  return turn <= tolerance && shift <= tolerance * size;
}

}  // namespace backbend::skin
