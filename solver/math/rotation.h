#pragma once
#include <glm/gtc/quaternion.hpp>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <span>

/// Rotations of the solver. Unit quaternions throughout; q and -q are one rotation. A frame is a
/// rotation whose columns are its axes in rig space: `frame * dvec3(1, 0, 0)` is its X axis.
///
/// Two choices decide whether a spine flips, so each has one home here: which way a slerp goes
/// (slerp_short, slerp_raw), and what the shortest arc does where there is none (shortest_arc).
namespace backbend::solver {

inline constexpr glm::dvec3 kAxisX{1.0, 0.0, 0.0};
inline constexpr glm::dvec3 kAxisY{0.0, 1.0, 0.0};
inline constexpr glm::dvec3 kAxisZ{0.0, 0.0, 1.0};
inline constexpr glm::dquat kNoTurn{1.0, 0.0, 0.0, 0.0};

constexpr double kPi = 3.14159265358979323846;
constexpr double radians(double deg) { return deg * (kPi / 180.0); }
constexpr double degrees(double rad) { return rad * (180.0 / kPi); }

/// A turn by `angle` radians about the unit vector `axis`, right-handed. Any angle.
glm::dquat turn_about(const glm::dvec3& axis, double angle);

/// R = Rz Ry Rx for a control's three Euler channels, radians, X innermost. Any angles: channels
/// past 180 degrees only change the sign of the quaternion.
glm::dquat from_euler_xyz(double rx, double ry, double rz);
/// The same from the sines and cosines of half the angles x, y, z.
glm::dquat from_half_angles(const double* sine, const double* cosine);

/// The axes of a unit quaternion; cheaper than three products.
glm::dvec3 x_axis(const glm::dquat& frame);
glm::dvec3 y_axis(const glm::dquat& frame);
glm::dvec3 z_axis(const glm::dquat& frame);

/// The smallest rotation that takes unit `from` to unit `to`.
///
/// Undefined where they point exactly apart (within rounding, |from + to| < 1e-14): then half a
/// turn about `half_turn_axis`, made perpendicular to `from`; if that axis is parallel to `from`,
/// about the perpendicular nearest the least aligned coordinate axis.
glm::dquat shortest_arc(const glm::dvec3& from, const glm::dvec3& to,
                        const glm::dvec3& half_turn_axis);

/// A quaternion within 1e-4 of unit length, brought to it: the square of what was missing stays.
/// Products of unit quaternions are that near; no root, no division.
inline glm::dquat renormalised(const glm::dquat& q) { return q * (1.5 - 0.5 * glm::dot(q, q)); }

/// `q` = swing * twist: `twist` turns about the unit vector `axis`, `swing` has no turn about it.
///
/// `twist_angle` is in (-2 pi, 2 pi] as the quaternion's sign says; wrap() it for the rotation's.
/// Undefined where `q` swings the axis by exactly half a turn: twist is then the identity.
/// Source: P. Dobrowolski, "Swing-twist decomposition in Clifford algebra", arXiv:1506.05481, 2015.
struct SwingTwist {
  glm::dquat swing{1.0, 0.0, 0.0, 0.0};
  glm::dquat twist{1.0, 0.0, 0.0, 0.0};
  double twist_angle = 0.0;
};
SwingTwist swing_twist(const glm::dquat& q, const glm::dvec3& axis);

/// An angle brought into (-pi, pi].
double wrap(double angle);
/// The value of `angle` + 2 pi k nearest to `near`.
double unwrap(double angle, double near);

/// The angle of the rotation between two unit quaternions, radians in [0, pi]. Accurate at both
/// ends, unlike the arc cosine.
double angle_between(const glm::dquat& a, const glm::dquat& b);
/// The angle between two vectors of any length, radians in [0, pi]; 0 where either is zero.
double angle_between(const glm::dvec3& a, const glm::dvec3& b);

/// Spherical interpolation the short way: b's sign is chosen so that the turn is at most pi.
/// Jumps by 2 pi t of rotation as the turn from a to b passes pi.
glm::dquat slerp_short(const glm::dquat& a, const glm::dquat& b, double t);
/// Spherical interpolation between the quaternions as stored, up to a turn of 2 pi. Where b is -a
/// no arc is defined and a is returned.
glm::dquat slerp_raw(const glm::dquat& a, const glm::dquat& b, double t);

/// The frame of a bone at rest: X along `direction` (any length > 0), Z nearest to `left`,
/// Y = Z x X. Where `left` is parallel to the bone (within 1e-6 rad), the coordinate axis least
/// aligned with the bone takes its place.
glm::dquat rest_frame(const glm::dvec3& direction, const glm::dvec3& left);

/// rest_frame() as axes in columns: exact where the bone and `left` lie along coordinate axes.
glm::dmat3 rest_axes(const glm::dvec3& direction, const glm::dvec3& left);

/// The rotation from_euler_xyz() about `axes` instead of the coordinate axes: what a control in
/// that rest frame does to rig space. Bends in a coordinate plane stay in it to the last bit.
glm::dquat euler_turn(const glm::dmat3& axes, const glm::dquat& euler);

/// `frame` carried so that its X axis becomes unit `new_x`, by the shortest arc; a doubling back
/// turns it about its own Z axis.
glm::dquat transport(const glm::dquat& frame, const glm::dvec3& new_x);

/// Frames of a chain: out[0] carries `start` to direction[0], out[i] carries out[i - 1] to
/// direction[i]. A zero direction keeps the frame before it. Spans of one length.
///
/// A direction that doubles back on the one before has no shortest arc, and all frames from there
/// on jump with it. `margin`, where it is given, gets how far each frame is from that: the least
/// angle, so far along the chain, by which a direction misses its predecessor's opposite (radians).
void transport_along(const glm::dquat& start, std::span<const glm::dvec3> direction,
                     std::span<glm::dquat> out, std::span<double> margin = {});

/// A unit vector perpendicular to unit `v`: the least aligned coordinate axis, made perpendicular.
glm::dvec3 any_perpendicular(const glm::dvec3& v);

}  // namespace backbend::solver
