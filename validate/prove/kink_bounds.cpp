#include "validate/prove/kink_bounds.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "solver/math/rotation.h"

namespace backbend::validate {
namespace {

using solver::Interval;
using solver::IntervalVector;
using Stretches = std::vector<solver::BoxCourse::Stretch>;

constexpr double kNoBound = std::numeric_limits<double>::infinity();
constexpr double kMostTurn = 2.0;   // radians, of an arc or between two bones
constexpr double kRounding = 1e-9;  // of bounds that are worked out in doubles, times 1 + that

/// By how much each joint's share of the chain differs from its share of the curve.
std::vector<Interval> share_differences(const Stretches& stretch) {
  const auto share = [](const Interval& before, const Interval& after) {
    return Interval((Interval(before.lo) / (Interval(before.lo) + Interval(after.hi))).lo,
                    (Interval(before.hi) / (Interval(before.hi) + Interval(after.lo))).hi);
  };
  const std::size_t bones = stretch.size();
  std::vector<Interval> bone_after(bones + 1, 0.0), arc_after(bones + 1, 0.0);
  for (std::size_t k = bones; k-- > 0;) {
    bone_after[k] = stretch[k].bone + bone_after[k + 1];
    arc_after[k] = stretch[k].arc + arc_after[k + 1];
  }
  std::vector<Interval> difference(bones + 1, 0.0);
  Interval bone, arc;  // before the joint
  for (std::size_t j = 1; j < bones; ++j) {
    bone += stretch[j - 1].bone;
    arc += stretch[j - 1].arc;
    difference[j] = share(bone, bone_after[j]) - share(arc, arc_after[j]);
  }
  return difference;
}

/// How far the nearest place on straight pieces of this length can be from that on the curve, for
/// what is within `apart` of both. Near that place the square of the distance to the curve grows by
/// at least 1 - bend apart times the square of the way, and the pieces are within bend piece^2 / 8.
double nearest_place_error(double apart, double bend, double piece) {
  const double steepness = 1.0 - bend * apart;
  if (!(steepness > 0.0)) return kNoBound;
  const double cut_off = bend * piece * piece / 8.0;
  return 2.0 * std::sqrt(cut_off * (apart + cut_off) / steepness);
}

/// A rotation vector moves as fast as the two directions between which it turns, times this.
double angle_over_sine(double angle) { return angle > 1e-3 ? angle / std::sin(angle) : 1.001; }

/// Of a joint whose excess is unknown but for its size, radians, in a direction that rest's may
/// have.
double degrees_with(double excess, const glm::dvec3& at_rest) {
  return solver::degrees(excess + glm::length(at_rest));
}

/// A bound from how much each stretch bends at the most, in whatever direction.
double kink_by_bends(const solver::BoxCourse& course, std::span<const glm::dvec3> rest_excess,
                     std::size_t points) {
  const Stretches& stretch = course.stretch;
  const std::size_t bones = stretch.size();
  double arcs = 0.0, bend = 0.0, corner = 0.0, corners = 0.0;
  for (const auto& s : stretch) {
    if (!(std::isfinite(s.bend) && s.bone.lo > 0.0 && s.arc.lo > 0.0)) return kNoBound;
    arcs += s.arc.hi;
    bend = std::max(bend, s.bend);
    corner = std::max(corner, s.corner);
    corners += s.corner;
  }
  // The check sees the curve as straight pieces. Each cuts off at most bend step^2 / 8, and of a
  // corner a quarter of itself; they are shorter than the curve by what they turn.
  const double whole = course.before + arcs;
  const double step = whole / static_cast<double>(points - 1);
  const double cut_off = step * (bend * step / 8.0 + corner / 4.0);
  const double shorter =
      whole * bend * bend * step * step / 24.0 + corners * step * (corner + bend * step) / 8.0;
  std::vector<double> gap;  // between a joint and the place that the check takes for it
  for (const Interval& d : share_differences(stretch))
    gap.push_back(d.most() * arcs + shorter + 4.0 * cut_off);

  // How far each bone can point from the chord that it is compared with, and the chord's turning.
  std::vector<double> off(bones), turn(bones);
  for (std::size_t k = 0; k < bones; ++k) {
    const std::size_t first = k > 0 ? k - 1 : k, last = std::min(k + 1, bones - 1);
    double least = kNoBound, own_bend = 0.0, own_corner = 0.0;
    for (std::size_t i = first; i <= last; ++i) {
      least = std::min(least, stretch[i].arc.lo);
      own_bend = std::max(own_bend, stretch[i].bend);
      own_corner += stretch[i].corner;
    }
    const double moved = gap[k] + gap[k + 1];
    if (!(moved < 0.5 * least)) return kNoBound;  // the chord's ends stay on these stretches
    turn[k] = own_bend * (stretch[k].arc.hi + moved) + own_corner;
    if (!(turn[k] < kMostTurn)) return kNoBound;
    const double cosine = std::cos(0.5 * turn[k]), shortest = stretch[k].arc.lo - moved;
    // On a circle a chord turns by half of what the tangent at its end does, and nowhere by more;
    // past a corner its end moves askew.
    double rate = 0.5 * own_bend;
    if (own_corner > 0.0)
      rate = (rate + std::sin(std::min(own_corner, 1.5)) / shortest) / (cosine * cosine);
    off[k] = rate * moved + std::asin(std::min(1.0, 2.0 * cut_off / (shortest * cosine)));
  }
  double most = 0.0;
  for (std::size_t i = 1; i < bones; ++i) {
    const double sum = off[i - 1] + off[i];
    // Without corners a chord halves what its arc turns.
    const double angle = (turn[i - 1] + turn[i]) * (corners > 0.0 ? 1.0 : 0.5) + sum;
    if (!(angle < kMostTurn)) return kNoBound;
    most = std::max(most, degrees_with(angle_over_sine(angle) * sum, rest_excess[i]));
  }
  return most * (1.0 + kRounding);
}

/// The chain on a curve whose tangents and bends are known over the box. All in the course's unit.
class CourseOnCurve {
 public:
  explicit CourseOnCurve(const solver::BoxCourse& course)
      : curve_(*course.curve),
        unit_(course.unit),
        before_(course.before),
        stretch_(course.stretch),
        beside_(course.beside) {
    // What is known of a bone narrows its arc, and so where the next bones lie.
    for (int round = 0; round < 2; ++round) {
      Interval at(before_);
      for (auto& s : stretch_) {
        const Interval ratio = chord_over_arc({at, at + s.arc}, s.arc);
        s.bone = common(s.bone, s.arc * ratio);
        s.arc = common(s.arc, s.bone / ratio);
        at = at + s.arc;
      }
    }
  }

  double most_kink(std::span<const glm::dvec3> rest_excess, std::size_t points) const {
    const std::size_t bones = stretch_.size();
    std::vector<Interval> at{Interval(before_)}, gap;
    for (const auto& s : stretch_) at.push_back(at.back() + s.arc);
    const Interval arcs = at.back() - Interval(before_);
    if (!arcs.is_finite()) return kNoBound;
    // The check sees the curve as straight pieces, which are shorter than it. Where the chain
    // begins past the curve's start, their nearest place may be off by what one of them cuts off.
    const double piece = at.back().hi / static_cast<double>(points - 1);
    const double shorter = square_of_bends(at) * piece * piece / 24.0;
    const double off = before_ > 0.0 ? 2.0 * cut_off({at[0], at[0]}, piece) : 0.0;
    const Interval astray = Interval(-1.0, 1.0) * (Interval(shorter) + Interval(off));
    if (beside_) {
      // The places between move with the last one, each by its share.
      const double bend = most_bend(at.back() + beside_->end + Interval(-2.0 * piece, 2.0 * piece));
      const double error = nearest_place_error(beside_->apart, bend, piece);
      if (!(error < piece)) return kNoBound;
      const Interval end = beside_->end + Interval(-error, error);
      for (const Interval& place : at) gap.push_back(place / arcs * end + astray);
    } else {
      for (const Interval& difference : share_differences(stretch_))
        gap.push_back(difference * arcs + astray);
    }
    std::vector<Bone> bone;
    for (std::size_t k = 0; k < bones; ++k) {
      bone.push_back(on_its_way({at[k] + hull(0.0, gap[k]), at[k + 1] + hull(0.0, gap[k + 1])},
                                stretch_[k].arc, gap[k], gap[k + 1], piece));
    }
    if (beside_ && !leave_the_curve(bone)) return kNoBound;
    double most = 0.0;
    for (std::size_t i = 1; i < bones; ++i) {
      const double kink = degrees_with(change(bone[i - 1], bone[i]), rest_excess[i]);
      if (!std::isfinite(kink)) return kNoBound;
      most = std::max(most, kink);
    }
    return most * (1.0 + kRounding);
  }

 private:
  static constexpr std::size_t kParts = 24;  // of an arc, whose bends are told apart
  struct Ends {
    Interval from, to;
  };
  /// A bone on its way from where it lies to the chord that it is compared with.
  struct Bone {
    IntervalVector along;       // unit
    Interval ratio;             // of chord and arc
    IntervalVector from_start;  // the mean of the tangents less that at the start
    IntervalVector to_end;      // the tangent at the end less the mean
    IntervalVector turned;      // by how much `along` turns on the way
    double askew = 0.0;         // what straight pieces can add to that, radians
    // Of a bone beside the curve, whose way begins off its chord:
    IntervalVector lag;   // the bone's direction across the chord's
    double second = 0.0;  // the most that is of second order in `lag` and `turned`
  };

  static IntervalVector around(double r) { return {{-r, r}, {-r, r}, {-r, r}}; }
  static IntervalVector from_zero(const IntervalVector& v) {
    return {hull(0.0, v.x), hull(0.0, v.y), hull(0.0, v.z)};
  }
  static Interval place(const Ends& ends, double share) {
    return (Interval(1.0) - Interval(share)) * ends.from + Interval(share) * ends.to;
  }
  /// Places on one part of an arc.
  static Interval part(const Ends& ends, std::size_t i) {
    const double parts = static_cast<double>(kParts), number = static_cast<double>(i);
    return hull(place(ends, number / parts), place(ends, (number + 1.0) / parts));
  }
  IntervalVector bend_over(const Interval& place) const {
    return unit_ * curve_.bend_over(place * unit_);
  }
  double most_bend(const Interval& place) const { return length(bend_over(place)).hi; }
  /// How far a straight piece can be from the curve.
  double cut_off(const Ends& ends, double piece) const {
    const Interval around = hull(ends.from, ends.to) + Interval(-piece, piece);
    return most_bend({std::max(0.0, around.lo), around.hi}) * piece * piece / 8.0;
  }
  /// The integral of the square of the bend, from the curve's start on.
  double square_of_bends(const std::vector<Interval>& at) const {
    const auto on = [&](const Interval& place, double arc) {
      const double bend = most_bend(place);
      return bend * bend * arc;
    };
    double sum = before_ > 0.0 ? on({0.0, before_}, before_) : 0.0;
    for (std::size_t k = 0; k < stretch_.size(); ++k) {
      for (std::size_t i = 0; i < kParts; ++i)
        sum += on(part({at[k], at[k + 1]}, i), stretch_[k].arc.hi / static_cast<double>(kParts));
    }
    return sum;
  }

  /// The variance of what has turned on the way, from what turns on each part.
  static double variance(const std::array<double, kParts>& turn) {
    double before = 0.0, mean = 0.0, square = 0.0;
    for (const double t : turn) {
      const double after = before + t;
      mean += 0.5 * (before + after);
      square += (before * before + before * after + after * after) / 3.0;
      before = after;
    }
    mean /= static_cast<double>(kParts);
    return square / static_cast<double>(kParts) - mean * mean;
  }

  /// The length of a chord over that of its arc. Its square is 1 less half the mean square of the
  /// difference of two tangents of the arc, which is at most twice the variance of the bend summed
  /// up, and at least twice that of its part along any one direction.
  Interval chord_over_arc(const Ends& ends, const Interval& arc) const {
    std::array<IntervalVector, kParts> bend;
    glm::dvec3 sum(0.0);
    for (std::size_t i = 0; i < kParts; ++i) {
      bend[i] = bend_over(part(ends, i));
      sum += glm::dvec3(bend[i].x.middle(), bend[i].y.middle(), bend[i].z.middle());
    }
    const double size = glm::length(sum);
    const glm::dvec3 way = size > 0.0 && std::isfinite(size)
                               ? sum * ((1.0 - 1e-12) / size)  // no longer than 1
                               : glm::dvec3(0.0);
    std::array<double, kParts> least{}, most{};
    bool one_way = true;
    const double parts = static_cast<double>(kParts);
    for (std::size_t i = 0; i < kParts; ++i) {
      const Interval along = dot(bend[i], {way.x, way.y, way.z});
      one_way = one_way && along.lo >= 0.0;
      least[i] = arc.lo / parts * along.lo;
      most[i] = arc.hi / parts * length(bend[i]).hi;
    }
    const double least_variance = one_way ? variance(least) * (1.0 - kRounding) : 0.0;
    const double most_variance = variance(most) * (1.0 + kRounding);
    if (!std::isfinite(most_variance)) return Interval::entire();
    return square_root(Interval(1.0) -
                       Interval(std::min(least_variance, most_variance), most_variance));
  }

  Bone on_its_way(const Ends& ends, const Interval& arc, const Interval& start_gap,
                  const Interval& end_gap, double piece) const {
    Bone bone;
    const Interval own = arc + hull(0.0, end_gap - start_gap);
    const Interval share(1.0 / static_cast<double>(kParts));
    IntervalVector mean;
    for (std::size_t i = 0; i < kParts; ++i) {
      const Interval at = part(ends, i);
      const IntervalVector turn = (share * own) * bend_over(at);
      const Interval passed((static_cast<double>(i) + 0.5) / static_cast<double>(kParts));
      bone.to_end = bone.to_end + passed * turn;
      bone.from_start = bone.from_start + (Interval(1.0) - passed) * turn;
      mean = mean + share * curve_.tangent_over(at * unit_);
    }
    bone.ratio = chord_over_arc(ends, own);
    const Interval chord = bone.ratio * own;
    bone.along = Interval(1.0) / bone.ratio * mean;
    bone.turned = Interval(1.0) / chord *
                  across(bone.along, end_gap * bone.to_end + start_gap * bone.from_start);
    bone.askew =
        chord.lo > 0.0 ? std::asin(std::min(1.0, 2.0 * cut_off(ends, piece) / chord.lo)) : kNoBound;
    return bone;
  }

  /// The next bone's direction less this one's, both on the curve.
  static IntervalVector step_between(const Bone& a, const Bone& b) {
    return a.to_end + b.from_start + (Interval(1.0) - b.ratio) * b.along -
           (Interval(1.0) - a.ratio) * a.along;
  }

  /// Lets the ways begin at the bones of a chain beside the curve. False where these point too far
  /// from their chords.
  ///
  /// A bone aims at the next joint on the curve from past the one before it. So its part across the
  /// chord is that of the bone before, times how far past, over the distance. From there to the
  /// chord that it is compared with it goes straight, and is stretched to a unit vector on the way.
  bool leave_the_curve(std::vector<Bone>& bone) const {
    double before = 0.0;  // how far the bone before points from its chord
    for (std::size_t k = 1; k < bone.size(); ++k) {
      Bone& own = bone[k];
      const Interval distance = beside_->bone - beside_->past[k + 1];
      const Interval share = beside_->past[k] / distance;
      own.lag = share * across(own.along, step_between(bone[k - 1], own) - bone[k - 1].lag +
                                              around(before * before));
      const double angle = angle_over_sine(0.5) * length(own.lag).hi;
      const double turned = length(own.turned).hi;
      const Interval chord = own.ratio * stretch_[k].arc;
      if (!(distance.lo > 0.0 && beside_->past[k].hi < chord.lo && angle + turned < 0.2))
        return false;
      own.second = 1.2 * angle * (0.5 * angle + turned);
      before = angle;
    }
    for (Bone& own : bone) own.turned = own.turned - own.lag;
    return true;
  }

  /// By how much the rotation vector from one bone to the next changes on their way, at the most.
  /// With directions a and b = a + e, that is angle / sine times a x b, of which the first changes
  /// by the cosine's e . (a' - b').
  static double change(const Bone& a, const Bone& b) {
    const IntervalVector apart =
        step_between(a, b) + from_zero(b.lag - a.lag) + around(a.second + b.second);
    const IntervalVector along = a.along + from_zero(a.lag) + around(a.second);
    const double chord = length(apart).hi, askew = a.askew + b.askew;
    const double second = a.second + b.second;
    const IntervalVector between = b.turned - a.turned;
    const double moved =
        length(cross(along, between) - cross(apart, a.turned)).hi + (1.0 + chord) * second;
    const double angle = 2.0 * std::asin(std::min(1.0, 0.5 * chord));
    if (!(angle + askew < kMostTurn) || !std::isfinite(moved)) return kNoBound;
    const double sine = std::sin(angle);
    const double grown = angle > 1e-3 ? (sine - angle * std::cos(angle)) / (sine * sine) : angle;
    return angle_over_sine(angle) * moved + grown * chord * (length(between).hi + second) +
           angle_over_sine(angle + askew) * askew;
  }

  const solver::BoxTangents& curve_;
  Interval unit_;
  double before_;
  Stretches stretch_;
  const std::optional<solver::BoxCourse::Beside>& beside_;
};

/// Of a chain that comes with its chords: the check's own formula.
Interval kink_of_held(const solver::BoxCourse::Held& held,
                      std::span<const glm::dvec3> rest_excess) {
  Interval worst(0.0);
  for (std::size_t i = 0; i < held.joint.size(); ++i) {
    const auto& joint = held.joint[i];
    const auto arc = [](const std::array<solver::BoxVector, 2>& way) {
      return arc_between(unit(way[0]), unit(way[1]));
    };
    const solver::BoxVector curve = arc(joint.chord);
    solver::BoxVector excess = arc(joint.bone) - curve;
    const glm::dvec3& at_rest = rest_excess[i + 1];
    double unknown = 0.0;
    if (joint.turn)
      excess = excess - *joint.turn * solver::BoxVector(at_rest);
    else
      unknown = glm::length(at_rest);
    if (!excess.is_finite()) return {0.0, kNoBound};
    double turned = 0.0;  // what the curve's straight pieces can turn both chords by
    for (std::size_t side = 0; side < 2; ++side) {
      const double shortest = length(joint.chord[side].value()).lo, off = joint.astray[side];
      if (off > 0.0) turned += shortest > 0.0 ? std::asin(std::min(1.0, off / shortest)) : kNoBound;
    }
    const double angle = length(curve.value()).hi + turned;
    if (turned > 0.0 && !(angle < kMostTurn)) return {0.0, kNoBound};
    if (turned > 0.0) unknown += angle_over_sine(angle) * turned;
    const Interval size = length(excess).value;
    worst = {std::max(worst.lo, solver::degrees(std::max(0.0, size.lo - unknown))),
             std::max(worst.hi, solver::degrees(size.hi + unknown))};
  }
  return {worst.lo * (1.0 - kRounding), worst.hi * (1.0 + kRounding)};
}

}  // namespace

solver::Interval kink_over(const solver::BoxCourse& course, std::span<const glm::dvec3> rest_excess,
                           std::size_t points, double enough) {
  std::vector<glm::dvec3> along(rest_excess.begin(), rest_excess.end());
  if (course.from_last) std::reverse(along.begin(), along.end());
  const bool on_its_curve = !course.stretch.empty() && !course.beside;
  const double by_bends = on_its_curve ? kink_by_bends(course, along, points) : kNoBound;
  if (course.held && by_bends > enough) {
    const Interval held = kink_of_held(*course.held, along);
    return {held.lo, std::max(held.lo, std::min(held.hi, by_bends))};
  }
  if (by_bends <= enough || !course.curve || !course.curve->is_finite()) return {0.0, by_bends};
  return {0.0, std::min(by_bends, CourseOnCurve(course).most_kink(along, points))};
}

}  // namespace backbend::validate
