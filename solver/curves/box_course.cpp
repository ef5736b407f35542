#include "solver/curves/box_course.h"

#include <limits>
#include <utility>

#include "solver/curves/box_curve.h"

namespace backbend::solver {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::infinity();
constexpr double kMostTurn = 2.0;  // of a stretch, radians: Schur's circle is less than half a turn

/// Half of what an arc of this length turns at the most.
Interval half_turn(const Interval& length, double bend) {
  return Interval(0.5) * Interval(bend) * Interval(length.hi);
}

/// The most that the curve bends between two places, radians per unit.
double most_bend(const BoxTangents& curve, const Interval& place, const Interval& unit) {
  if (!curve.is_finite() || !unit.is_finite()) return kUnknown;
  const Interval bend =
      place.is_finite() ? length(curve.bend_over(place * unit)) : Interval(curve.most_bend());
  const Interval own = bend * unit;
  return own.is_finite() ? own.hi : kUnknown;
}

/// Finds the place nearest to a last joint that stands `past` the curve's end along `aim`, in units
/// of the curve's length. Leaves the end without a bound where that place may be far from it.
///
/// At the nearest place the tangent is perpendicular to the line to the joint. So the arc from
/// there to the end, projected on that tangent, is as long as the projection of what the joint
/// lacks.
void find_end(const BoxTangents& curve, const IntervalVector& aim, const Interval& past,
              BoxCourse::Beside& beside) {
  beside.end = Interval::entire();
  const Interval reach = Interval(3.0) * Interval(past.most());
  if (!(reach.hi < 1.0)) return;
  const IntervalVector tangent =
      curve.tangent_over((Interval(1.0) - Interval(0.0, reach.hi)) * curve.length().value);
  const auto cosine = [](const Interval& c) { return common(c, Interval(-1.0, 1.0)); };
  const Interval own = cosine(dot(tangent, tangent)), bone = cosine(dot(aim, tangent));
  // The nearest place is at most twice as far from the end as the joint is. Tangents that agree by
  // two thirds make its arc at most 1.5 times that, so `reach` holds it. To a joint past the end
  // the end itself is nearest.
  if (!(own.lo > 2.0 / 3.0 && bone.lo > 0.0)) return;
  const Interval missing(std::max(0.0, -past.hi), std::max(0.0, -past.lo));
  const Interval left = missing * bone / own;
  const auto across = [](const Interval& cosine) {
    return square_root(Interval(1.0) - square(Interval(cosine.lo)));
  };
  beside.end = -left;
  beside.apart = (left * across(own) + missing * across(bone)).hi;
}

}  // namespace

BoxCourse::Stretch stretch_along(const Interval& arc, double bend, double corner) {
  const Interval half = half_turn(arc, bend);
  if (!(half.hi < 0.5 * kMostTurn) || !(arc.lo > 0.0))
    return {{0.0, arc.hi}, arc, kUnknown, corner};
  // sin(h) / h is at least 1 - h^2 / 6.
  const double least = (arc * (Interval(1.0) - square(half) / Interval(6.0))).lo;
  return {{least, arc.hi}, arc, bend, corner};
}

BoxCourse::Stretch stretch_over_corners(const Interval& arc, double bend, double corner) {
  const Interval half = half_turn(arc, bend) + Interval(0.5) * Interval(corner);
  if (!(half.hi < 0.5 * kMostTurn) || !(arc.lo > 0.0))
    return {{0.0, arc.hi}, arc, kUnknown, corner};
  return {{(arc * cosine(half)).lo, arc.hi}, arc, bend, corner};
}

BoxCourse::Stretch stretch_under(const Interval& bone, double bend) {
  const Interval half = half_turn(bone, bend);
  const double most_sine = sine(Interval(0.5 * kMostTurn)).lo;
  if (!(half.hi < most_sine) || !(bone.lo > 0.0)) return {bone, Interval::entire(), kUnknown, 0.0};
  // asin(x) / x rises; near 0 the quotient would lose its digits.
  const Interval x(std::max(half.hi, 1e-3));
  const double most = (Interval(bone.hi) * (arc_sine(x) / x)).hi;
  return {bone, {bone.lo, most}, bend, 0.0};
}

BoxCourse walked_course(BoxTangents curve, std::span<const double> bone, const Interval& scale) {
  BoxCourse course;
  course.unit = scale;
  Interval at(0.0);
  for (const double own : bone) {
    BoxCourse::Stretch next = stretch_under(own, most_bend(curve, Interval::entire(), scale));
    if (next.bend < kUnknown)
      next = stretch_under(own, most_bend(curve, hull(at, at + next.arc), scale));
    at = at + next.arc;
    course.stretch.push_back(next);
  }
  course.still = curve.still();
  course.curve = std::move(curve);
  return course;
}

BoxCourse course_at_shares(BoxTangents curve, const Interval& used, std::span<const double> share) {
  BoxCourse course;
  course.unit = used;
  course.before = share.front();
  for (std::size_t k = 1; k < share.size(); ++k) {
    const Interval from(share[k - 1]), to(share[k]);
    // The check's straight piece at the first joint may begin before it.
    const Interval place = hull(k == 1 ? Interval(0.0) : from, to);
    course.stretch.push_back(stretch_along(to - from, most_bend(curve, place, used)));
  }
  course.still = curve.still();
  course.curve = std::move(curve);
  return course;
}

BoxCourse chased_course(BoxTangents curve, std::size_t bones, const BoxReal& bone) {
  const Interval count(static_cast<double>(bones)), whole = curve.length().value;
  std::vector<double> share;
  for (std::size_t k = 0; k <= bones; ++k) share.push_back(double(k) / double(bones));
  BoxCourse course = course_at_shares(curve, whole, share);
  BoxCourse::Beside& beside = course.beside.emplace();
  beside.bone = bone.value / count;
  beside.past.assign(1, 0.0);
  if (!curve.is_finite()) return course;
  BoxChase chain;
  for (std::size_t k = 0; k < bones; ++k) {
    chain.go(curve.mean_between(share[k], share[k + 1]), bone);
    beside.past.push_back(chain.past().value / count);
  }
  find_end(curve, chain.aim().value(), beside.past.back(), beside);
  return course;
}

}  // namespace backbend::solver
