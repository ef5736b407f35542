#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "solver/math/gauss_legendre.h"
#include "solver/math/rotation.h"
#include "solver/systems/even_shape.h"

namespace backbend::solver {
namespace {

using glm::dvec3;

constexpr double kRounding = 1e-12;
constexpr double kMostOfPiece = 0.02;  // radians that a piece whose mean is taken at once may turn

/// The angle between two unit vectors, rounded upward; 0 only for the same.
double most_corner(const dvec3& a, const dvec3& b) {
  return a == b ? 0.0 : angle_between(a, b) + kRounding;
}

BoxVector around(double radius) {
  const BoxReal all(Interval(-radius, radius));
  return {all, all, all};
}

/// Weights at a place, or in the mean over a stretch.
using Weights = std::array<double, 4>;

/// On a stretch of the rest spine: the weights' means, and how far each is from its mean in the
/// root of the mean square.
struct Spread {
  Weights mean{}, deviation{};
};

/// Exact but for rounding: of weights that are polynomials of degree four at most.
Spread spread_of(const EvenWeights& weights, double from, double to) {
  static const auto rule = [] {
    std::array<std::vector<double>, 2> r;
    gauss_legendre(5, r[0], r[1]);
    return r;
  }();
  std::array<Weights, 5> at;
  Spread out;
  for (std::size_t i = 0; i < at.size(); ++i) {
    at[i] = weights.at(from + (to - from) * rule[0][i]);
    for (std::size_t f = 0; f < 4; ++f) out.mean[f] += rule[1][i] * at[i][f];
  }
  for (std::size_t f = 0; f < 4; ++f) {
    double square = 0.0;
    for (std::size_t i = 0; i < at.size(); ++i) {
      const double off = at[i][f] - out.mean[f];
      square += rule[1][i] * off * off;
    }
    out.deviation[f] = std::sqrt(square) + kRounding;
  }
  return out;
}

}  // namespace

/// The spine over a box, piece by piece, each seen from a place near it, where it hardly moves.
class EvenCourse {
 public:
  EvenCourse(const EvenShape& shape, std::span<const BoxReal> upper)
      : shape_(shape), upper_(upper), places_(shape.places_.joint) {
    for (std::size_t ch = 0; ch < upper.size(); ++ch) most_[ch] = upper[ch].value.most();
    for (std::size_t i = 0; i + 1 < shape.panel_.size(); ++i)
      corner_.push_back(most_corner(shape.panel_[i].in_middle, shape.panel_[i + 1].in_middle));
    corner_.push_back(0.0);
    for (const EvenShape::Panel& p : shape.panel_) bend_.push_back(most_bend(p));
  }

  BoxCourse course(std::size_t points) const {
    BoxCourse course;
    BoxCourse::Stretch next;
    double inside = 0.0, insides = 0.0;  // corners between two joints, and between any
    for (std::size_t i = 0; i < corner_.size(); ++i) {
      const EvenShape::Panel& panel = shape_.panel_[i];
      next.bend = std::max(next.bend, bend_[i]);
      next.arc = next.arc + (Interval(panel.to) - Interval(panel.from));
      next.corner += corner_[i];
      if (!panel.ends_bone) {
        inside += corner_[i];
        continue;
      }
      course.stretch.push_back(inside == 0.0
                                   ? stretch_along(next.arc, next.bend, next.corner)
                                   : stretch_over_corners(next.arc, next.bend, next.corner));
      next = {};
      next.corner = corner_[i];
      insides += inside;
      inside = 0.0;
    }
    if (insides > 0.0) course.held = held(points);
    return course;
  }

 private:
  /// Turns from one place of the spine to others, in rest axes.
  ///
  /// From place i to place s the three turns of a control, Rz Ry Rx, leave
  /// (Rx Ry)i^-1 Rz(dz) (Ry Rx)i, then Rx,i^-1 Ry(dy) Rx,i, then Rx(dx): turns by what each angle
  /// changes, about axes that depend on i alone.
  class From {
   public:
    From(const EvenCourse& course, double place)
        : course_(course), own_(course.shape_.weights_.at(place)) {
      const EvenShape& shape = course.shape_;
      const auto angle = [&](std::size_t ch) {
        return BoxReal(own_[EvenWeights::index_of(ch)]) * course.upper_[ch];
      };
      const auto axes_of = [&](std::size_t first, auto&& in_rest) {
        const BoxTurn back_x = conjugate(turn_about({1, 0, 0}, angle(first)));
        const BoxTurn back_y = conjugate(turn_about({0, 1, 0}, angle(first + 1)));
        axis_[first] = in_rest(BoxVector(dvec3(1, 0, 0)));
        axis_[first + 1] = in_rest(back_x * BoxVector(dvec3(0, 1, 0)));
        axis_[first + 2] = in_rest(back_x * (back_y * BoxVector(dvec3(0, 0, 1))));
      };
      const BoxTurn top_back = conjugate(from_euler_xyz(angle(3), angle(4), angle(5)));
      axes_of(3, [&](const BoxVector& v) { return shape.top_axes_ * v; });
      axes_of(0, [&](const BoxVector& v) {
        return shape.top_axes_ * (top_back * (glm::transpose(shape.middle_from_top_) * v));
      });
    }

    BoxTurn to(const Weights& weights) const {
      BoxTurn turn;
      for (const std::size_t ch : {2, 1, 0, 5, 4, 3}) {
        const std::size_t f = EvenWeights::index_of(ch);
        if (weights[f] == own_[f] || course_.most_[ch] == 0.0) continue;
        const BoxReal half = BoxReal(0.5 * (weights[f] - own_[f])) * course_.upper_[ch];
        const BoxReal s = sine(half);
        const BoxVector v = s * axis_[ch];
        constexpr double kAny = std::numeric_limits<double>::infinity();
        turn = turn * BoxTurn(cosine(half), v.x, v.y, v.z, {kAny, kAny, kAny});
      }
      return turn;
    }

   private:
    const EvenCourse& course_;
    Weights own_;
    std::array<BoxVector, kUpperChannels> axis_;
  };

  /// The most that the posed spine bends on a panel, radians per length of the spine.
  double most_bend(const EvenShape::Panel& panel) const {
    // A channel turns the tangent as fast as it turns, times the sine between the two: its X turns
    // what lies along X by nothing.
    const auto angle = [&](int ch) { return Interval(most_[std::size_t(ch)]); };
    const auto off_x = [](const dvec3& v) {
      const double sine = std::hypot(v.y, v.z);
      return Interval(v.x > 0.0 ? std::asin(std::min(1.0, sine)) : kPi) + Interval(0.0, kRounding);
    };
    const EvenWeights& weights = shape_.weights_;
    const Interval in_top = off_x(panel.in_top);
    Interval in_middle = off_x(panel.in_middle) + Interval(2.0) * in_top;
    for (const int ch : {4, 5}) in_middle += Interval(weights.of(ch)(panel.to)) * angle(ch);
    Interval bend(0.0);
    for (int ch = 0; ch < kUpperChannels; ++ch) {
      const double slope = weights.of(ch).peak_slope(panel.from, panel.to);
      Interval turn = Interval(slope) * Interval(1.0 + kRounding) * angle(ch);
      if (ch % 3 == 0) turn = turn * Interval(std::min(1.0, (ch < 3 ? in_middle : in_top).hi));
      bend += turn;
    }
    return bend.hi;
  }

  /// The most that the frame turns between two places, by what each of these weights changes.
  double most_turn(const Weights& change) const {
    double turn = 0.0;
    for (std::size_t ch = 0; ch < kUpperChannels; ++ch)
      turn += change[EvenWeights::index_of(ch)] * most_[ch];
    return turn * (1.0 + kRounding);
  }
  double most_turn(double from, double to) const {
    const Weights a = shape_.weights_.at(from), b = shape_.weights_.at(to);
    return most_turn({b[0] - a[0], b[1] - a[1], b[2] - a[2], b[3] - a[3]}) + kRounding;
  }

  /// From one place to another on one panel. With every angle at its mean, what is left out is of
  /// second order: half the square of what the angles differ from that, in the mean.
  BoxVector way(const From& frame, const EvenShape::Panel& panel, double from, double to) const {
    const BoxVector tangent(shape_.top_axes_ * panel.in_top);
    const int pieces = std::max(1, int(std::ceil(most_turn(from, to) / kMostOfPiece)));
    BoxVector sum(dvec3(0.0));
    for (int i = 0; i < pieces; ++i) {
      const double a = from + (to - from) * i / pieces, b = from + (to - from) * (i + 1) / pieces;
      const Spread spread = spread_of(shape_.weights_, a, b);
      const double off = most_turn(spread.deviation);
      sum = sum + BoxReal(b - a) * (frame.to(spread.mean) * tangent + around(0.5 * off * off));
    }
    return sum;
  }

  BoxVector way(const From& frame, double from, double to) const {
    BoxVector sum(dvec3(0.0));
    for (const EvenShape::Panel& p : shape_.panel_) {
      const double a = std::max(p.from, from), b = std::min(p.to, to);
      if (a < b) sum = sum + way(frame, p, a, b);
    }
    return sum;
  }

  /// From a joint to a place on the curve: to where that is in the box's middle, and on from there
  /// along any tangent near it.
  BoxVector from_joint(const From& frame, std::size_t k, const BoxReal& place) const {
    const double joint = places_[k], middle = place.center.middle();
    const BoxReal on = place - BoxReal(middle);
    const Interval stretch = Interval(middle) + hull(Interval(0.0), on.value);
    if (!(0.0 < stretch.lo && stretch.hi < 1.0)) return BoxVector::undefined();
    std::optional<BoxVector> along;
    for (const EvenShape::Panel& p : shape_.panel_) {
      if (p.to < stretch.lo || stretch.hi < p.from) continue;
      const double from = std::max(p.from, stretch.lo), to = std::min(p.to, stretch.hi);
      const BoxVector tangent =
          frame.to(shape_.weights_.at(0.5 * (from + to))) * BoxVector(shape_.top_axes_ * p.in_top) +
          around(most_turn(from, to));
      along = along ? hull(*along, tangent) : tangent;
    }
    const BoxVector known = middle < joint ? -way(frame, middle, joint) : way(frame, joint, middle);
    return known + on * *along;
  }

  /// The most that the posed spine bends between two places, on all panels that it touches there.
  double bend_between(double from, double to) const {
    double bend = 0.0;
    for (std::size_t i = 0; i < bend_.size(); ++i) {
      const EvenShape::Panel& p = shape_.panel_[i];
      if (p.to >= from && p.from <= to) bend = std::max(bend, bend_[i]);
    }
    return bend;
  }

  /// The check's curve: straight between places at equal steps of the spine. It is shorter than the
  /// spine by little but where a piece holds a corner.
  struct Pieces {
    struct Corner {
      double from, to;  // of the piece
      Interval lost;    // how much shorter it is
    };
    double step;
    std::vector<Corner> corner;
    Interval lost;    // by all pieces
    Interval smooth;  // by any number of pieces without corners
  };

  /// The square of a chord over its arc is 1 less half the mean square of the difference of two
  /// tangents: with one corner inside, those on its two sides, which bends change by little.
  Pieces pieces_of(std::size_t points) const {
    Pieces out{1.0 / double(points - 1), {}, {}, {}};
    const double most = bend_between(0.0, 1.0) * out.step;
    out.smooth = Interval(0.0, most * most / 24.0 * (1.0 + kRounding));
    out.lost = out.smooth;
    for (std::size_t i = 0; i < corner_.size(); ++i) {
      if (corner_[i] == 0.0) continue;
      const double at = shape_.panel_[i].to, number = std::floor(at / out.step);
      const double from = number * out.step, share = std::clamp(at / out.step - number, 0.0, 1.0);
      const Interval apart = Interval(2.0) * sine(Interval(0.5 * corner_[i]));
      const double bent = bend_between(from, from + out.step) * out.step;
      const Interval differ = Interval(share * (1.0 - share)) * square(apart) +
                              Interval(-1.0, 1.0) * Interval(bent * (apart.hi + bent) + kRounding);
      const Interval chord = square_root(common(Interval(1.0) - differ, Interval(0.0, 1.0)));
      Interval lost = Interval(out.step) * (Interval(1.0) - chord);
      if (!out.corner.empty() && out.corner.back().from == from) {  // what both lose is not known
        lost = Interval(0.0, out.step);
        out.lost = out.lost - out.corner.back().lost;
        out.corner.pop_back();
      }
      out.corner.push_back({from, from + out.step, lost});
      out.lost = out.lost + lost;
    }
    return out;
  }
  /// What the pieces before a place have lost.
  static Interval lost_before(const Pieces& pieces, const Interval& place) {
    Interval lost = pieces.smooth;
    for (const auto& c : pieces.corner) {
      if (c.from >= place.hi) break;
      lost = lost + (c.to <= place.lo ? c.lost : hull(Interval(0.0), c.lost));
    }
    return lost;
  }
  /// How far a place at a share of a piece can be from that at the same share of its arc: an eighth
  /// of its bend times the step's square, and of a corner a quarter times the step.
  double deviation(const Pieces& pieces, const Interval& place) const {
    const double from = (std::floor(place.lo / pieces.step) - kRounding) * pieces.step,
                 to = (std::ceil(place.hi / pieces.step) + kRounding) * pieces.step;
    const double bend = bend_between(from, to);
    double corner = 0.0;
    for (std::size_t i = 0; i < corner_.size(); ++i)
      if (const double at = shape_.panel_[i].to; at >= from && at <= to) corner += corner_[i];
    return pieces.step * (bend * pieces.step / 8.0 + corner / 4.0) * (1.0 + kRounding);
  }

  /// The chain's shares differ from the curve's: a bone with a corner inside is shorter than its
  /// arc, by how much depends on the pose.
  BoxCourse::Held held(std::size_t points) const {
    const std::size_t bones = places_.size() - 1;
    BoxCourse::Held held;
    std::vector<From> frame;
    std::vector<BoxReal> length(bones);
    for (std::size_t i = 1; i < bones; ++i) {
      frame.emplace_back(*this, places_[i]);
      const From& own = frame.back();
      BoxCourse::Held::Joint joint;
      joint.bone = {way(own, places_[i - 1], places_[i]), way(own, places_[i], places_[i + 1])};
      joint.turn = own.to(shape_.weights_.at(shape_.places_.frame[i - 1]));
      if (i == 1) length[0] = solver::length(joint.bone[0]);
      length[i] = solver::length(joint.bone[1]);
      held.joint.push_back(joint);
    }
    std::vector<BoxReal> after(bones, BoxReal(0.0)), place(bones + 1, BoxReal(0.0));
    for (std::size_t k = bones; k-- > 1;)
      after[k - 1] = length[k] + (k < bones - 1 ? after[k] : BoxReal(0.0));
    const Pieces pieces = pieces_of(points);
    std::vector<double> astray(bones + 1, 0.0);
    BoxReal before(0.0);
    for (std::size_t k = 1; k < bones; ++k) {
      before = before + length[k - 1];
      // Both parts of the chain change; their quotient does so by less.
      const BoxReal share = BoxReal(1.0) / (BoxReal(1.0) + after[k - 1] / before);
      const Interval near = share.value + Interval(-1.0, 1.0) * Interval(pieces.lost.most());
      place[k] = share * BoxReal(Interval(1.0) - pieces.lost) + BoxReal(lost_before(pieces, near));
      astray[k] = deviation(pieces, place[k].value);
    }
    for (std::size_t i = 1; i < bones; ++i) {
      BoxCourse::Held::Joint& joint = held.joint[i - 1];
      std::array<BoxVector, 3> to_place;
      for (std::size_t n = 0; n < 3; ++n) {
        const std::size_t k = i - 1 + n;
        to_place[n] =
            k == 0 || k == bones ? BoxVector(dvec3(0.0)) : from_joint(frame[i - 1], k, place[k]);
      }
      for (std::size_t side = 0; side < 2; ++side) {
        joint.chord[side] = joint.bone[side] + to_place[side + 1] - to_place[side];
        joint.astray[side] = astray[i - 1 + side] + astray[i + side];
      }
    }
    return held;
  }

  const EvenShape& shape_;
  std::span<const BoxReal> upper_;
  const std::vector<double>& places_;
  UpperChannels most_{};
  std::vector<double> corner_, bend_;  // at each panel's end; on it
};

BoxCourse EvenShape::course(std::span<const BoxReal> upper, std::size_t points) const {
  assert(share_end_.size() == 1 && upper.size() == kUpperChannels);
  return EvenCourse(*this, upper).course(points);
}

}  // namespace backbend::solver
