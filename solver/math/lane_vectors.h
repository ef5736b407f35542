#pragma once
#include <glm/gtc/quaternion.hpp>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include "solver/math/lanes.h"

namespace backbend::solver {

/// Four vectors side by side. Every operation is glm's on each lane, in glm's order of sums, so
/// that a lane has the bits of the same code on a glm::dvec3.
struct LaneVector {
  Lanes x, y, z;

  LaneVector() = default;
  LaneVector(Lanes ax, Lanes ay, Lanes az) : x(ax), y(ay), z(az) {}
  LaneVector(const glm::dvec3& all) : x(all.x), y(all.y), z(all.z) {}  // NOLINT: as Lanes

  friend LaneVector operator+(const LaneVector& a, const LaneVector& b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
  }
  friend LaneVector operator-(const LaneVector& a, const LaneVector& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
  }
  friend LaneVector operator*(Lanes f, const LaneVector& v) { return {f * v.x, f * v.y, f * v.z}; }
  LaneVector& operator+=(const LaneVector& b) { return *this = *this + b; }
};

inline Lanes dot(const LaneVector& a, const LaneVector& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline Lanes length(const LaneVector& v) { return square_root(dot(v, v)); }
inline LaneVector cross(const LaneVector& a, const LaneVector& b) {
  return {a.y * b.z - b.y * a.z, a.z * b.x - b.z * a.x, a.x * b.y - b.x * a.y};
}
inline LaneVector select(Lanes::Mask m, const LaneVector& yes, const LaneVector& no) {
  return {select(m, yes.x, no.x), select(m, yes.y, no.y), select(m, yes.z, no.z)};
}
inline LaneVector operator*(const glm::dmat3& m, const LaneVector& v) {
  return {Lanes(m[0][0]) * v.x + Lanes(m[1][0]) * v.y + Lanes(m[2][0]) * v.z,
          Lanes(m[0][1]) * v.x + Lanes(m[1][1]) * v.y + Lanes(m[2][1]) * v.z,
          Lanes(m[0][2]) * v.x + Lanes(m[1][2]) * v.y + Lanes(m[2][2]) * v.z};
}

/// Four quaternions side by side, likewise.
struct LaneTurn {
  Lanes w, x, y, z;

  LaneTurn() = default;
  LaneTurn(Lanes aw, Lanes ax, Lanes ay, Lanes az) : w(aw), x(ax), y(ay), z(az) {}
  LaneTurn(Lanes aw, const LaneVector& v) : w(aw), x(v.x), y(v.y), z(v.z) {}
  LaneTurn(const glm::dquat& all) : w(all.w), x(all.x), y(all.y), z(all.z) {}  // NOLINT: as Lanes

  friend LaneTurn operator*(const LaneTurn& p, const LaneTurn& q) {
    return {p.w * q.w - p.x * q.x - p.y * q.y - p.z * q.z,
            p.w * q.x + p.x * q.w + p.y * q.z - p.z * q.y,
            p.w * q.y + p.y * q.w + p.z * q.x - p.x * q.z,
            p.w * q.z + p.z * q.w + p.x * q.y - p.y * q.x};
  }
  friend LaneTurn operator*(const LaneTurn& q, Lanes f) {
    return {q.w * f, q.x * f, q.y * f, q.z * f};
  }
  friend LaneVector operator*(const LaneTurn& q, const LaneVector& v) {
    const LaneVector u(q.x, q.y, q.z);
    const LaneVector once = cross(u, v), twice = cross(u, once), two = q.w * once + twice;
    return v + Lanes(2.0) * two;
  }
};

inline Lanes dot(const LaneTurn& a, const LaneTurn& b) {
  return (a.w * b.w + a.x * b.x) + (a.y * b.y + a.z * b.z);
}
inline LaneTurn renormalised(const LaneTurn& q) {
  return q * (Lanes(1.5) - Lanes(0.5) * dot(q, q));
}

}  // namespace backbend::solver
