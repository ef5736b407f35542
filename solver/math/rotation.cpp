#include "solver/math/rotation.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <glm/geometric.hpp>

namespace backbend::solver {
namespace {

glm::dvec3 vector_part(const glm::dquat& q) { return {q.x, q.y, q.z}; }

glm::dquat quaternion(double w, const glm::dvec3& v) { return {w, v.x, v.y, v.z}; }

/// `v` without its part along unit `axis`, unit length; nullopt-like zero where nothing is left.
glm::dvec3 perpendicular_part(const glm::dvec3& v, const glm::dvec3& axis, double least_sine) {
  const double size = glm::length(v);
  if (!(size > 0.0)) return glm::dvec3(0.0);
  const glm::dvec3 unit = v / size;
  const glm::dvec3 rest = unit - glm::dot(unit, axis) * axis;
  const double sine = glm::length(rest);
  if (!(sine > least_sine)) return glm::dvec3(0.0);
  return rest / sine;
}

glm::dquat slerp_as_stored(const glm::dquat& a, const glm::dquat& b, double cosine, double t) {
  // Half the rotation's angle, from the chord lengths: good near 0 where acos is not.
  const double half_angle = 2.0 * std::atan2(glm::length(b - a), glm::length(b + a));
  const double sine = std::sin(half_angle);
  if (cosine < 0.0 && sine < 1e-12) return a;  // b = -a: every great circle will do, none is right
  if (sine < 1e-9) return glm::normalize(a + (b - a) * t);  // the arc is its own chord
  return glm::normalize(a * (std::sin((1.0 - t) * half_angle) / sine) +
                        b * (std::sin(t * half_angle) / sine));
}

}  // namespace

glm::dquat turn_about(const glm::dvec3& axis, double angle) {
  return quaternion(std::cos(0.5 * angle), std::sin(0.5 * angle) * axis);
}

glm::dquat from_euler_xyz(double rx, double ry, double rz) {
  const double s[] = {std::sin(0.5 * rx), std::sin(0.5 * ry), std::sin(0.5 * rz)};
  const double c[] = {std::cos(0.5 * rx), std::cos(0.5 * ry), std::cos(0.5 * rz)};
  return from_half_angles(s, c);
}

glm::dquat from_half_angles(const double* s, const double* c) {
  // qz * qy * qx, multiplied out.
  return {c[2] * c[1] * c[0] + s[2] * s[1] * s[0], c[2] * c[1] * s[0] - s[2] * s[1] * c[0],
          c[2] * s[1] * c[0] + s[2] * c[1] * s[0], s[2] * c[1] * c[0] - c[2] * s[1] * s[0]};
}

glm::dvec3 x_axis(const glm::dquat& f) {
  return {1.0 - 2.0 * (f.y * f.y + f.z * f.z), 2.0 * (f.x * f.y + f.w * f.z),
          2.0 * (f.x * f.z - f.w * f.y)};
}

glm::dvec3 y_axis(const glm::dquat& f) {
  return {2.0 * (f.x * f.y - f.w * f.z), 1.0 - 2.0 * (f.x * f.x + f.z * f.z),
          2.0 * (f.y * f.z + f.w * f.x)};
}

glm::dvec3 z_axis(const glm::dquat& f) {
  return {2.0 * (f.x * f.z + f.w * f.y), 2.0 * (f.y * f.z - f.w * f.x),
          1.0 - 2.0 * (f.x * f.x + f.y * f.y)};
}

glm::dquat shortest_arc(const glm::dvec3& from, const glm::dvec3& to,
                        const glm::dvec3& half_turn_axis) {
  // Through the bisector: half the angle is measured where it is well conditioned, so the result
  // is good up to the last digits before the two point apart.
  const glm::dvec3 sum = from + to;
  const double size = glm::length(sum);
  if (size > 1e-14) {
    const glm::dvec3 bisector = sum / size;
    return glm::normalize(quaternion(glm::dot(from, bisector), glm::cross(from, bisector)));
  }
  glm::dvec3 axis = perpendicular_part(half_turn_axis, from, 1e-9);
  if (axis == glm::dvec3(0.0)) axis = any_perpendicular(from);
  return quaternion(0.0, axis);
}

SwingTwist swing_twist(const glm::dquat& q, const glm::dvec3& axis) {
  const double along = glm::dot(vector_part(q), axis);
  const double size = std::hypot(q.w, along);
  if (!(size > 1e-15)) return {q, kNoTurn, 0.0};
  SwingTwist parts;
  parts.twist = quaternion(q.w / size, (along / size) * axis);
  parts.swing = q * glm::conjugate(parts.twist);
  parts.twist_angle = 2.0 * std::atan2(along, q.w);
  return parts;
}

double wrap(double angle) {
  const double turned = std::remainder(angle, 2.0 * kPi);
  return turned <= -kPi ? kPi : turned;
}

double unwrap(double angle, double near) { return near + std::remainder(angle - near, 2.0 * kPi); }

double angle_between(const glm::dquat& a, const glm::dquat& b) {
  const glm::dquat turn = glm::conjugate(a) * b;
  return 2.0 * std::atan2(glm::length(vector_part(turn)), std::abs(turn.w));
}

double angle_between(const glm::dvec3& a, const glm::dvec3& b) {
  return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
}

glm::dquat slerp_short(const glm::dquat& a, const glm::dquat& b, double t) {
  const double cosine = glm::dot(a, b);
  return cosine < 0.0 ? slerp_as_stored(a, -b, -cosine, t) : slerp_as_stored(a, b, cosine, t);
}

glm::dquat slerp_raw(const glm::dquat& a, const glm::dquat& b, double t) {
  return slerp_as_stored(a, b, glm::dot(a, b), t);
}

glm::dvec3 any_perpendicular(const glm::dvec3& v) {
  const glm::dvec3 size = glm::abs(v);
  const glm::dvec3 axis =
      size.x <= size.y && size.x <= size.z ? kAxisX : (size.z <= size.y ? kAxisZ : kAxisY);
  return glm::normalize(axis - glm::dot(axis, v) * v);
}

glm::dmat3 rest_axes(const glm::dvec3& direction, const glm::dvec3& left) {
  assert(glm::dot(direction, direction) > 0.0);
  const glm::dvec3 x = glm::normalize(direction);
  glm::dvec3 z = perpendicular_part(left, x, 1e-6);
  if (z == glm::dvec3(0.0)) z = any_perpendicular(x);
  return {x, glm::cross(z, x), z};
}

glm::dquat rest_frame(const glm::dvec3& direction, const glm::dvec3& left) {
  return glm::normalize(glm::quat_cast(rest_axes(direction, left)));
}

glm::dquat euler_turn(const glm::dmat3& axes, const glm::dquat& euler) {
  return quaternion(euler.w, axes * vector_part(euler));
}

glm::dquat transport(const glm::dquat& frame, const glm::dvec3& new_x) {
  return glm::normalize(shortest_arc(x_axis(frame), new_x, z_axis(frame)) * frame);
}

void transport_along(const glm::dquat& start, std::span<const glm::dvec3> direction,
                     std::span<glm::dquat> out, std::span<double> margin) {
  assert(direction.size() == out.size());
  assert(margin.empty() || margin.size() == out.size());
  glm::dquat frame = start;
  glm::dvec3 before = x_axis(start);
  double least = kPi;
  for (std::size_t i = 0; i < direction.size(); ++i) {
    if (direction[i] != glm::dvec3(0.0)) {
      if (!margin.empty()) least = std::min(least, kPi - angle_between(before, direction[i]));
      frame = transport(frame, direction[i]);
      before = direction[i];
    }
    out[i] = frame;
    if (!margin.empty()) margin[i] = least;
  }
}

}  // namespace backbend::solver
