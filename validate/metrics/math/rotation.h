#pragma once
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/vec3.hpp>

namespace backbend::validate {

constexpr double kPi = 3.14159265358979323846;
constexpr double degrees(double radians) { return radians * (180.0 / kPi); }
constexpr double radians_from(double deg) { return deg * (kPi / 180.0); }

/// An angle brought to (-pi, pi].
inline double wrapped(double angle) {
  const double turns = std::round(angle / (2.0 * kPi));
  const double rest = angle - 2.0 * kPi * turns;
  return rest <= -kPi ? rest + 2.0 * kPi : rest;
}

/// Rotation vector of a unit quaternion: axis times angle, radians in [0, pi]. q and -q are one
/// rotation. atan2 and not acos, which loses half its digits near zero.
inline glm::dvec3 rotation_vector(const glm::dquat& q) {
  const glm::dvec3 v = q.w < 0.0 ? -glm::dvec3(q.x, q.y, q.z) : glm::dvec3(q.x, q.y, q.z);
  const double sine = glm::length(v);
  // The series keeps the direction of turns too small for a quotient: 2 v (1 + sine^2 / 6 ...).
  if (sine < 1e-9) return 2.0 * v;
  return v * (2.0 * std::atan2(sine, std::abs(q.w)) / sine);
}

/// The rotation of a rotation vector, unit.
inline glm::dquat rotation(const glm::dvec3& vector) {
  const double angle = glm::length(vector);
  const double half = 0.5 * angle;
  const glm::dvec3 v = vector * (angle < 1e-9 ? 0.5 : std::sin(half) / angle);
  return glm::dquat(std::cos(half), v.x, v.y, v.z);
}

/// World rotation vector from one orientation to another: `to = exp(v) from`.
inline glm::dvec3 turn_between(const glm::dquat& from, const glm::dquat& to) {
  return rotation_vector(to * glm::conjugate(from));
}

/// Angle of the rotation that takes one orientation to another: radians in [0, pi].
inline double angle_between(const glm::dquat& from, const glm::dquat& to) {
  const glm::dquat turn = glm::conjugate(from) * to;
  return 2.0 * std::atan2(glm::length(glm::dvec3(turn.x, turn.y, turn.z)), std::abs(turn.w));
}

/// Angle of two vectors of any length but zero: radians in [0, pi].
inline double angle_between(const glm::dvec3& a, const glm::dvec3& b) {
  return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
}

/// Rotation vector of the shortest arc from one direction to another (any length but zero). At
/// exactly half a turn the axis is undefined; some axis square to `a` is given.
inline glm::dvec3 arc_between(const glm::dvec3& a, const glm::dvec3& b) {
  const glm::dvec3 normal = glm::cross(a, b);
  const double sine = glm::length(normal), cosine = glm::dot(a, b);
  if (sine > 0.0) return normal * (std::atan2(sine, cosine) / sine);
  if (cosine >= 0.0) return glm::dvec3(0.0);
  const glm::dvec3 other =
      std::abs(a.x) < std::abs(a.y) ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
  return glm::normalize(glm::cross(a, other)) * kPi;
}

/// Signed turn of a rotation about a unit axis: its twist, radians in (-pi, pi]. What remains is
/// the swing. Undefined where the axis is turned to its opposite; 0 is returned there.
/// Source: P. Dobrowolski, "Swing-twist decomposition in Clifford algebra", arXiv:1506.05481.
inline double twist_about(const glm::dquat& turn, const glm::dvec3& axis) {
  const double along = glm::dot(glm::dvec3(turn.x, turn.y, turn.z), axis);
  if (along == 0.0 && turn.w == 0.0) return 0.0;
  return wrapped(2.0 * std::atan2(along, turn.w));
}

inline bool is_finite(const glm::dvec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}
inline bool is_finite(const glm::dquat& q) {
  return std::isfinite(q.w) && std::isfinite(q.x) && std::isfinite(q.y) && std::isfinite(q.z);
}

}  // namespace backbend::validate
