#pragma once
#include <array>
#include <glm/gtc/quaternion.hpp>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include "solver/math/interval.h"

/// Scalars, vectors and rotations over a whole box of poses at once: the types with which a
/// solver's templates run for `backbend prove`, in the place of double, glm::dvec3 and glm::dquat.
/// Functions have the names and the meaning of those in rotation.h and glm.
namespace backbend::solver {

/// How many channels a box may vary at once; all others are fixed.
inline constexpr int kBoxVariables = 3;
using BoxSlopes = std::array<Interval, kBoxVariables>;

/// A number that depends on the pose, over a box of poses. Poses are counted from the box's middle
/// in half widths: every variable y runs over [-1, 1].
///
/// `value` encloses the number at every pose, `center` at the middle one, and `slope[j]` its
/// partial derivative by y_j at every pose. A number that is only Lipschitz (the smaller of two)
/// has its generalised gradient in the slopes. So value is inside center + sum of slope[j] [-1, 1]
/// (the mean value theorem), and every operation keeps the narrower of the two enclosures: widths
/// fall with the square of the box's.
struct BoxReal {
  Interval value, center;
  BoxSlopes slope{};

  BoxReal() = default;
  BoxReal(double exactly) : value(exactly), center(exactly) {}  // NOLINT: constants read better
  explicit BoxReal(const Interval& constant) : value(constant), center(constant) {}
  /// What may be undefined somewhere in the box; nothing finite comes of it.
  static BoxReal undefined();

  /// The variable y_j itself, as a number from `low` to `high`.
  static BoxReal variable(int j, double low, double high);
  bool is_finite() const;
};

/// Narrows the value by the mean value form, for slopes that were found otherwise. What has no
/// finite value has no finite slopes.
BoxReal narrowed(BoxReal r);

BoxReal operator-(const BoxReal& a);
BoxReal operator+(const BoxReal& a, const BoxReal& b);
BoxReal operator-(const BoxReal& a, const BoxReal& b);
BoxReal operator*(const BoxReal& a, const BoxReal& b);
BoxReal operator/(const BoxReal& a, const BoxReal& b);
BoxReal square(const BoxReal& a);
BoxReal square_root(const BoxReal& a);
BoxReal sine(const BoxReal& a);
BoxReal cosine(const BoxReal& a);
BoxReal smaller(const BoxReal& a, const BoxReal& b);
BoxReal larger(const BoxReal& a, const BoxReal& b);
/// Encloses both.
BoxReal hull(const BoxReal& a, const BoxReal& b);

struct IntervalVector {
  Interval x, y, z;
};
IntervalVector operator+(const IntervalVector& a, const IntervalVector& b);
IntervalVector operator-(const IntervalVector& a, const IntervalVector& b);
IntervalVector operator*(const Interval& f, const IntervalVector& v);
Interval dot(const IntervalVector& a, const IntervalVector& b);
IntervalVector cross(const IntervalVector& a, const IntervalVector& b);
Interval length(const IntervalVector& v);

struct BoxVector {
  BoxReal x, y, z;

  BoxVector() = default;
  BoxVector(BoxReal ax, BoxReal ay, BoxReal az) : x(ax), y(ay), z(az) {}
  static BoxVector undefined();
  BoxVector(const glm::dvec3& exactly)  // NOLINT: as BoxReal
      : x(exactly.x), y(exactly.y), z(exactly.z) {}
  bool is_finite() const { return x.is_finite() && y.is_finite() && z.is_finite(); }
  IntervalVector value() const { return {x.value, y.value, z.value}; }
  IntervalVector slope(std::size_t j) const { return {x.slope[j], y.slope[j], z.slope[j]}; }
};

BoxVector operator-(const BoxVector& a);
BoxVector operator+(const BoxVector& a, const BoxVector& b);
BoxVector operator-(const BoxVector& a, const BoxVector& b);
BoxVector operator*(const BoxReal& f, const BoxVector& v);
BoxVector operator/(const BoxVector& v, const BoxReal& f);
BoxVector operator*(const glm::dmat3& m, const BoxVector& v);
BoxReal dot(const BoxVector& a, const BoxVector& b);
BoxReal length(const BoxVector& v);
/// v / length(v), narrower: what v moves along itself is left out before it can widen anything.
BoxVector unit(const BoxVector& v);
/// The part of `moved` across a unit vector.
IntervalVector across(const IntervalVector& unit, const IntervalVector& moved);
BoxVector cross(const BoxVector& a, const BoxVector& b);
/// Encloses both.
BoxVector hull(const BoxVector& a, const BoxVector& b);
/// The rotation vector of the shortest arc from unit `from` to unit `to`. Not finite where it may
/// be longer than 2.3 radians somewhere in the box.
BoxVector arc_between(const BoxVector& from, const BoxVector& to);

/// Bounds of how fast something turns: radians for each variable's y, upward rounded.
using BoxRates = std::array<double, kBoxVariables>;

/// A rotation over a box, as a unit quaternion.
///
/// `rate[j]` bounds its angular speed as y_j moves. It is carried beside the components, because
/// the speeds of factors add up at most (the angle between rotations is the same however both are
/// turned), which is sharper than what the components' slopes say: a product of turns about fixed
/// axes has its rates to the last digit, however large the box.
struct BoxTurn {
  BoxReal w, x, y, z;
  BoxRates rate{};

  BoxTurn() : w(1.0) {}
  static BoxTurn undefined();
  BoxTurn(BoxReal aw, BoxReal ax, BoxReal ay, BoxReal az, BoxRates rates)
      : w(aw), x(ax), y(ay), z(az), rate(rates) {}
  BoxTurn(const glm::dquat& exactly)  // NOLINT: as BoxReal
      : w(exactly.w), x(exactly.x), y(exactly.y), z(exactly.z) {}
};

/// Takes the components' slopes as rates where they are smaller: of a unit quaternion q they are
/// 2 |dq|.
BoxTurn with_least_rates(BoxTurn q);

BoxTurn operator*(const BoxTurn& a, const BoxTurn& b);
BoxTurn conjugate(const BoxTurn& q);
BoxVector operator*(const BoxTurn& q, const BoxVector& v);
/// Unit already, as exact numbers are.
inline BoxTurn normalize(const BoxTurn& q) { return q; }
inline BoxTurn renormalised(const BoxTurn& q) { return q; }

BoxTurn turn_about(const glm::dvec3& axis, const BoxReal& angle);
BoxTurn from_euler_xyz(const BoxReal& rx, const BoxReal& ry, const BoxReal& rz);
BoxTurn euler_turn(const glm::dmat3& axes, const BoxTurn& euler);
/// The rotation that takes the unit axes X, Y, Z to these: a right-handed frame. Not finite where
/// it may be half a turn somewhere in the box. Rates are those of its components.
BoxTurn turn_to_axes(const BoxVector& x, const BoxVector& y, const BoxVector& z);
/// Not finite where somewhere in the box both ways round may be equally long.
BoxTurn slerp_short(const BoxTurn& a, const BoxTurn& b, double t);
/// Not finite where somewhere in the box the two may point apart.
BoxTurn shortest_arc(const BoxVector& from, const BoxVector& to, const BoxVector& half_turn_axis);

/// The angular speed of the frame whose X lies along `velocity` and whose Y is nearest to unit
/// `up`. Infinite where somewhere in the box the velocity may vanish or lie along `up`.
///
/// With unit axes x, y, z the frame turns by (z . v', y . v') / |v| across x, and about x by
/// ((up . x) (z . v') / |v| - z . up') / |x cross up|: what lengths do is left out before it can
/// widen anything.
BoxRates rates_of_aim(const BoxVector& velocity, const BoxVector& up);

/// How fast what the shortest arc from unit `from` to unit `to` carries along rolls about `to`,
/// more than it did about `from`: -(from x to) . (from' + to') / (1 + from . to), by each variable.
/// Not finite where somewhere in the box the two may point apart.
///
/// Of q = (w, from x to / 2w), w the cosine of half the angle, the angular speed is twice the
/// vector part of q' q*; its part along `to` comes to that.
BoxSlopes roll_of_arc(const BoxVector& from, const BoxVector& to);
/// The same where `turned`, to - from, is known better than both: of arcs far smaller than the box.
BoxSlopes roll_of_arc(const BoxVector& from, const BoxVector& to, const IntervalVector& turned);

/// sin(t h) / sin(h) over cosines c = cos(h), 0 < c <= 1, 0 <= t <= 1: what a slerp takes of its
/// end. Falls with c.
Interval slerp_weight(const Interval& c, double t);
/// Its derivative by c.
Interval slerp_weight_slope(const Interval& c, double t);

/// The types of one pose, and of a box of them, for templates.
struct PoseMath {
  using Real = double;
  using Vector = glm::dvec3;
  using Turn = glm::dquat;
};
struct BoxMath {
  using Real = BoxReal;
  using Vector = BoxVector;
  using Turn = BoxTurn;
};

}  // namespace backbend::solver
