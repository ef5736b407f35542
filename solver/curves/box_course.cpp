#include "solver/curves/box_course.h"

#include <algorithm>
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

/// Leaves only those variables that do not move any of these.
void leave_moved(const std::vector<BoxVector>& vector, std::array<bool, kBoxVariables>& still) {
  constexpr double kNothing = 1e-100;  // roundings of 0 are below it
  for (const BoxVector& v : vector) {
    for (std::size_t j = 0; j < still.size(); ++j) {
      const IntervalVector s = v.slope(j);
      still[j] = still[j] && std::max({s.x.most(), s.y.most(), s.z.most()}) < kNothing;
    }
  }
}

/// How far places on straight pieces between `points` points can be from those on the curve: each
/// piece cuts off at most bend step^2 / 8, and all together are shorter by a 24th of the step's
/// square times `squares`, the integral of the bend's square.
double astray(double length, double bend, double squares, std::size_t points) {
  const Interval step = Interval(length) / Interval(double(points - 1));
  return (square(step) * (Interval(squares) / Interval(24.0) + Interval(bend) / Interval(8.0))).hi;
}

/// The most that a Bezier piece bends: on each panel its second derivative over the square of the
/// first's part along one direction.
double most_bend(const BoxTangents::Legs& legs) {
  constexpr int kPanels = 4;
  const auto mixed = [](const IntervalVector& a, const IntervalVector& b, double t) {
    return Interval(1.0 - t) * a + Interval(t) * b;
  };
  const std::array<IntervalVector, 3> leg{legs[0].value(), legs[1].value(), legs[2].value()};
  const IntervalVector first = leg[1] - leg[0], last = leg[2] - leg[1];
  double most = 0.0;
  for (int panel = 0; panel < kPanels; ++panel) {
    const double from = double(panel) / kPanels, to = double(panel + 1) / kPanels;
    // A third of the derivative is a mean of these, as de Casteljau's scheme has it.
    const auto between = [&](double s, double t) {
      return mixed(mixed(leg[0], leg[1], s), mixed(leg[1], leg[2], s), t);
    };
    const std::array<IntervalVector, 3> third{between(from, from), between(from, to),
                                              between(to, to)};
    const double turn =
        std::max(length(mixed(first, last, from)).hi, length(mixed(first, last, to)).hi);
    double slowest = kUnknown;  // its part along the one in the middle, times that one's length
    for (const IntervalVector& way : third) slowest = std::min(slowest, dot(third[1], way).lo);
    if (!(slowest > 0.0)) return kUnknown;
    const Interval size = length(third[1]);
    most = std::max(
        most,
        (Interval(2.0 * turn) * square(size) / (Interval(3.0) * square(Interval(slowest)))).hi);
  }
  return most;
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

BoxCourse held_course(const BoxTangents& curve, std::size_t points, std::span<const double> share,
                      const std::vector<BoxVector>& bone, const std::vector<BoxTurn>& turn) {
  std::vector<BoxVector> chord;
  for (std::size_t k = 0; k < bone.size(); ++k) {
    const Interval arc = (Interval(share[k + 1]) - Interval(share[k])) * curve.length().value;
    const Interval least(std::max(0.0, arc.lo));
    chord.push_back(BoxReal(least) * curve.mean_between(share[k], share[k + 1]).way);
  }
  BoxCourse course;
  BoxCourse::Held& held = course.held.emplace();
  const double length = curve.length().value.hi, bend = curve.most_bend();
  const double off = 2.0 * astray(length, bend, bend * bend * length, points);
  for (std::size_t i = 1; i < bone.size(); ++i)
    held.joint.push_back(
        {{bone[i - 1], bone[i]}, {chord[i - 1], chord[i]}, turn[i - 1], {off, off}});
  course.still = curve.still();
  leave_moved(bone, course.still);
  return course;
}

BoxCourse course_through_joints(const CurveMap& map, std::size_t points,
                                std::span<const double> share,
                                const std::vector<std::vector<BoxVector>>& step) {
  constexpr int kPanels = 8;
  const std::size_t bones = step.size();
  std::vector<std::vector<BoxTangents::Legs>> legs;  // in each frame, of each piece
  std::vector<double> bend;                          // of each piece
  std::vector<BoxReal> arc{BoxReal(0.0)};            // up to each joint
  BoxCourse course;
  course.still.fill(true);
  for (std::size_t k = 0; k < bones; ++k) {
    legs.push_back(map.legs(step[k]));
    arc.push_back(arc.back() + BoxArc(legs[k][k], kPanels).length());
    bend.push_back(most_bend(legs[k][k]));
    leave_moved(step[k], course.still);
  }
  BoxCourse::Held& held = course.held.emplace();
  double squares = 0.0;
  for (std::size_t k = 0; k < bones; ++k)
    squares += bend[k] * bend[k] * (arc[k + 1] - arc[k]).value.hi;
  const double off = 2.0 * astray(arc.back().value.hi, *std::max_element(bend.begin(), bend.end()),
                                  squares, points);
  // From a joint to its place, which is a little further or less far on. Both ends stay.
  const auto to_place = [&](std::size_t joint, const BoxTangents::Legs& piece, std::size_t leg) {
    if (joint == 0 || joint == bones) return BoxVector(glm::dvec3(0.0));
    const BoxReal way = BoxReal(share[joint]) * arc.back() - arc[joint];
    if (!(way.value.most() <
          smaller((arc[joint] - arc[joint - 1]).value, (arc[joint + 1] - arc[joint]).value).lo))
      return BoxVector::undefined();
    const Interval bent(std::max(bend[joint - 1], bend[joint]));
    const double turned = (Interval(0.5) * bent * Interval(way.value.most())).hi;
    const BoxReal any(Interval(-turned, turned));  // of the mean tangent on the way
    return way * (unit(piece[leg]) + BoxVector(any, any, any));
  };
  for (std::size_t i = 1; i < bones; ++i) {
    const BoxVector before = to_place(i - 1, legs[i][i - 1], 0);
    const BoxVector at = to_place(i, legs[i][i], 0), after = to_place(i + 1, legs[i][i], 2);
    const BoxVector &below = step[i][i - 1], &above = step[i][i];
    held.joint.push_back(
        {{below, above}, {below + at - before, above + after - at}, {}, {off, off}});
  }
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
