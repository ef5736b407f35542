#include "validate/prove/plane_chain.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "validate/prove/plane_curve.h"

namespace backbend::validate {
namespace {

using solver::Interval;

/// A vector a X + b c with its derivatives by kappa, as PlaneBone has them.
using Vector = PlaneBone;

/// Products of two vectors over the kappas. X . X = c . c = 1, X . c = kappa.
Interval dot(const Interval& a, const Interval& b, const Interval& other_a, const Interval& other_b,
             const Interval& kappa) {
  return a * other_a + b * other_b + kappa * (a * other_b + b * other_a);
}

/// A number and its derivative by kappa.
struct Number {
  Interval value, slope;
};

/// The squares as in ChestCurve: nothing cancels.
Number size_of(const Vector& v, const Interval& kappa) {
  const Interval size =
      square_root(square(v.a + v.b * kappa) + square(v.b) * (Interval(1.0) - square(kappa)));
  return {size, (dot(v.a, v.b, v.a_by, v.b_by, kappa) + v.a * v.b) / size};
}

template <class Curve>
Vector way_between(const Curve& curve, const typename Curve::Place& from,
                   const typename Curve::Place& to) {
  const auto way = curve.way(from.u, to.u);
  const Interval three(3.0);
  return {way.along_x, way.along_c,
          three * (curve.alpha(to.u) * to.slope - curve.alpha(from.u) * from.slope),
          three * (curve.beta(to.u) * to.slope - curve.beta(from.u) * from.slope)};
}

/// The place at a share of the length; the ends are known.
template <class Curve>
std::optional<typename Curve::Place> place_at(const Curve& curve, int part, int parts) {
  using Place = typename Curve::Place;
  if (part == 0) return Place{0.0, 0.0};
  if (part == parts) return Place{1.0, 0.0};
  const Interval share = Interval(part) / Interval(parts);
  const auto& whole = curve.whole();
  return curve.at({share * whole.value, share * whole.center, share * whole.slope});
}

class Shares final : public PlaneChain {
 public:
  Shares(int bones, const ChestShape& shape) : bones_(bones), shape_(shape) {}

  std::vector<PlaneBone> bones(const Interval& kappa, int panels) const override {
    const ChestCurve curve(shape_, kappa, panels);
    if (!curve.whole().value.is_finite()) return {};
    std::vector<PlaneBone> out;
    auto from = place_at(curve, 0, bones_);
    for (int k = 1; k <= bones_; ++k) {
      const auto to = place_at(curve, k, bones_);
      if (!to) return {};
      out.push_back(way_between(curve, *from, *to));
      from = to;
    }
    return out;
  }

 private:
  int bones_;
  ChestShape shape_;
};

/// The curve between hips and chest, past its end straight on and as fast as there.
class GoneOn {
 public:
  explicit GoneOn(const ChestShape& shape) : shape_(shape) {}

  Interval alpha(const Interval& u) const { return shape_.alpha(clipped(u)); }
  Interval beta(const Interval& u) const { return shape_.beta(clipped(u)); }
  Interval alpha_slope(const Interval& u) const {
    return or_none(u, shape_.alpha_slope(clipped(u)));
  }
  Interval beta_slope(const Interval& u) const { return or_none(u, shape_.beta_slope(clipped(u))); }
  Interval alpha_bend(const Interval& u) const { return or_none(u, shape_.alpha_bend(u)); }
  Interval beta_bend(const Interval& u) const { return or_none(u, shape_.beta_bend(u)); }
  std::span<const double> knots() const { return knot_; }

 private:
  static Interval clipped(const Interval& u) { return {std::min(u.lo, 1.0), std::min(u.hi, 1.0)}; }
  static Interval or_none(const Interval& u, const Interval& slope) {
    return u.lo >= 1.0 ? Interval(0.0) : u.hi > 1.0 ? hull(slope, 0.0) : slope;
  }

  ChestShape shape_;
  std::array<double, 1> knot_{1.0};
};

class Steps final : public PlaneChain {
  using Curve = PlaneCurve<GoneOn>;

 public:
  Steps(int bones, const ChestShape& shape) : bones_(bones), shape_(shape) {}

  std::vector<PlaneBone> bones(const Interval& kappa, int panels) const override {
    const Curve curve(shape_, kappa, panels);
    if (!curve.whole().value.is_finite()) return {};
    // The solver's rest bones are as long as each other but for rounding.
    const Interval part = Interval(1.0 - 1e-12, 1.0 + 1e-12) / Interval(bones_);
    const auto& whole = curve.whole();
    const Curve::Length bone{part * whole.value, part * whole.center, part * whole.slope};
    std::vector<PlaneBone> out;
    Joint from{0.0, 0.0, 0.0};
    for (int k = 0; k < bones_; ++k) {
      const auto to = step(curve, kappa, from, bone);
      if (!to) return {};
      out.push_back(
          way_between(curve, Curve::Place{from.u, from.slope}, Curve::Place{to->u, to->slope}));
      from = *to;
    }
    return out;
  }

 private:
  /// Where a joint is on the curve: over all kappas, at the middle one, and its derivative.
  struct Joint {
    Interval u, center, slope;
  };

  /// The first place behind `from` that is a bone away, by an interval Newton step. The distance
  /// grows all the way there, for the curve does not turn by a right angle between. What a joint
  /// misses at the middle kappa is told apart from how it moves: both would widen with every bone.
  std::optional<Joint> step(const Curve& curve, const Interval& kappa, const Joint& from,
                            const Curve::Length& bone) const {
    const double middle = kappa.middle(), start = from.center.middle();
    double guess = start, speed = 0.0;
    for (int i = 0; i < 8; ++i) {
      const double gone = i == 0 ? 0.0 : distance(curve, middle, start, guess).middle();
      speed = curve.speed(guess).middle();
      if (!(speed > 0.0)) return std::nullopt;
      guess += (bone.center.middle() - gone) / speed;
    }
    const Interval off = kappa - Interval(middle);
    const Interval miss_there =
        distance(curve, middle, start, guess) - bone.center -
        along(curve, middle, from.center, guess, from.center) * (from.center - Interval(start));
    const Interval moves = by_kappa(curve, kappa, from.u, guess) -
                           along(curve, kappa, from.u, guess, from.u) * from.slope - bone.slope;
    const Interval miss = miss_there + moves * off;
    if (!miss.is_finite()) return std::nullopt;
    double reach = 1.3 * miss.most() / speed + 1e-12;
    for (int i = 0; i < 6; ++i, reach *= 2.0) {
      const Interval u = Interval(guess) + Interval(-reach, reach);
      if (!(u.lo > from.u.hi) || turns_far(curve, kappa, hull(from.u, u))) return std::nullopt;
      const Interval rise = along(curve, kappa, from.u, u, u);
      const Interval root = Interval(guess) - miss / rise;
      if (!(root.lo > u.lo && root.hi < u.hi)) continue;
      const Interval center = Interval(guess) - miss_there / rise;
      const Interval slope = (bone.slope - by_kappa(curve, kappa, from.u, root) +
                              along(curve, kappa, from.u, root, from.u) * from.slope) /
                             along(curve, kappa, from.u, root, root);
      return Joint{common(root, center + slope * off), center, slope};
    }
    return std::nullopt;
  }

  static Interval distance(const Curve& curve, const Interval& kappa, const Interval& u,
                           const Interval& v) {
    const auto way = curve.way(u, v);
    return size_of({way.along_x, way.along_c, 0.0, 0.0}, kappa).value;
  }
  /// How fast the distance grows with kappa alone.
  static Interval by_kappa(const Curve& curve, const Interval& kappa, const Interval& u,
                           const Interval& v) {
    const auto way = curve.way(u, v);
    return size_of({way.along_x, way.along_c, 0.0, 0.0}, kappa).slope;
  }

  /// The part of the velocity at `at` along the way from u to v.
  static Interval along(const Curve& curve, const Interval& kappa, const Interval& u,
                        const Interval& v, const Interval& at) {
    const auto way = curve.way(u, v);
    return Interval(3.0) * dot(way.along_x, way.along_c, curve.alpha(at), curve.beta(at), kappa) /
           size_of({way.along_x, way.along_c, 0.0, 0.0}, kappa).value;
  }

  /// Whether two velocities of a stretch may be a right angle apart.
  static bool turns_far(const Curve& curve, const Interval& kappa, const Interval& u) {
    return may_turn_far<6>(curve, kappa, u) && may_turn_far<24>(curve, kappa, u);
  }
  /// The same, as far as so many pieces of it tell.
  template <std::size_t kPieces>
  static bool may_turn_far(const Curve& curve, const Interval& kappa, const Interval& u) {
    std::array<Interval, kPieces> a, b;
    for (std::size_t i = 0; i < kPieces; ++i) {
      const auto at = [&](std::size_t k) { return u.lo + (u.hi - u.lo) * double(k) / kPieces; };
      const Interval piece(at(i), i + 1 == kPieces ? u.hi : at(i + 1));
      a[i] = curve.alpha(piece);
      b[i] = curve.beta(piece);
    }
    // A piece with itself, too: its velocities are any two of it.
    for (std::size_t i = 0; i < kPieces; ++i)
      for (std::size_t j = i; j < kPieces; ++j)
        if (!(dot(a[i], b[i], a[j], b[j], kappa).lo > 0.0)) return true;
    return false;
  }

  int bones_;
  GoneOn shape_;
};

/// The clamped uniform cubic B-spline of five points, from the steps between them along X and c:
/// its velocity is a quadratic B-spline of six times the first and last step and three times those
/// between, with a knot in the middle. Handed out by thirds, as PlaneCurve has it.
class FivePoints {
 public:
  explicit FivePoints(const std::array<double, 3>& length) {
    const Interval half(0.5), one(length[0]), two(length[1]), three(length[2]);
    alpha_ = pieces(Interval(2.0) * (half * one), half * (one + two), half * two, 0.0);
    beta_ = pieces(0.0, 0.0, half * three, Interval(2.0) * (half * three));
  }

  Interval alpha(const Interval& u) const { return over(alpha_, u, value); }
  Interval beta(const Interval& u) const { return over(beta_, u, value); }
  Interval alpha_slope(const Interval& u) const { return over(alpha_, u, slope); }
  Interval beta_slope(const Interval& u) const { return over(beta_, u, slope); }
  Interval alpha_bend(const Interval& u) const { return over(alpha_, u, bend); }
  Interval beta_bend(const Interval& u) const { return over(beta_, u, bend); }
  std::span<const double> knots() const { return knot_; }

 private:
  using Bernstein = std::array<Interval, 3>;
  using Pieces = std::array<Bernstein, 2>;

  static Pieces pieces(const Interval& first, const Interval& second, const Interval& third,
                       const Interval& last) {
    const Interval middle = Interval(0.5) * (second + third);
    return {Bernstein{first, second, middle}, Bernstein{middle, third, last}};
  }
  static Interval value(const Bernstein& c, const Interval& t) {
    const Interval s = Interval(1.0) - t;
    return c[0] * square(s) + Interval(2.0) * c[1] * s * t + c[2] * square(t);
  }
  // By u, of which a piece holds half.
  static Interval slope(const Bernstein& c, const Interval& t) {
    return Interval(4.0) * ((c[1] - c[0]) * (Interval(1.0) - t) + (c[2] - c[1]) * t);
  }
  static Interval bend(const Bernstein& c, const Interval&) {
    return Interval(8.0) * (c[2] - Interval(2.0) * c[1] + c[0]);
  }
  template <class Of>
  static Interval over(const Pieces& pieces, const Interval& u, const Of& of) {
    const Interval two(2.0), one(1.0);
    if (u.hi <= 0.5) return of(pieces[0], two * u);
    if (u.lo >= 0.5) return of(pieces[1], two * u - one);
    return hull(of(pieces[0], two * Interval(u.lo, 0.5)),
                of(pieces[1], two * Interval(0.5, u.hi) - one));
  }

  Pieces alpha_, beta_;
  std::array<double, 1> knot_{0.5};
};

class Chase final : public PlaneChain {
  using Curve = PlaneCurve<FivePoints>;

 public:
  Chase(int bones, const std::array<double, 3>& length, ChasedLength rule)
      : bones_(bones), shape_(length), rule_(rule) {}

  std::vector<PlaneBone> bones(const Interval& kappa, int panels) const override {
    const Curve curve(shape_, kappa, panels);
    if (!curve.whole().value.is_finite()) return {};
    const auto bone = bone_of(curve, kappa);
    if (!bone) return {};
    std::vector<PlaneBone> out;
    Vector missed{0.0, 0.0, 0.0, 0.0};  // from the last joint to the last goal
    auto from = place_at(curve, 0, bones_);
    for (int k = 1; k <= bones_; ++k) {
      const auto to = place_at(curve, k, bones_);
      if (!to) return {};
      const Vector step = way_between(curve, *from, *to);
      const Vector aim{step.a + missed.a, step.b + missed.b, step.a_by + missed.a_by,
                       step.b_by + missed.b_by};
      out.push_back(aim);
      // What is left of the way: (1 - bone / |aim|) aim, which is small as both are as long.
      const Number size = size_of(aim, kappa);
      const Interval left = (size.value - bone->value) / size.value;
      const Interval left_by = (bone->value * size.slope / size.value - bone->slope) / size.value;
      missed = {left * aim.a, left * aim.b, left * aim.a_by + left_by * aim.a,
                left * aim.b_by + left_by * aim.b};
      from = to;
    }
    return out;
  }

 private:
  std::optional<Number> bone_of(const Curve& curve, const Interval& kappa) const {
    const Interval count(bones_);
    if (rule_ == ChasedLength::arc)
      return Number{curve.whole().value / count, curve.whole().slope / count};
    const auto null = place_at(curve, 1, 9);
    if (!null) return std::nullopt;
    const Number way = size_of(way_between(curve, {0.0, 0.0}, *null), kappa);
    const Interval nine(9.0);
    return Number{nine * way.value / count, nine * way.slope / count};
  }

  int bones_;
  FivePoints shape_;
  ChasedLength rule_;
};

}  // namespace

std::unique_ptr<PlaneChain> chain_of_shares(int bones, double hip_depth, double chest_depth) {
  return std::make_unique<Shares>(bones, ChestShape(hip_depth, chest_depth));
}

std::unique_ptr<PlaneChain> chain_of_steps(int bones, double hip_depth, double chest_depth) {
  return std::make_unique<Steps>(bones, ChestShape(hip_depth, chest_depth));
}

std::unique_ptr<PlaneChain> chain_that_chases(int bones, const std::array<double, 3>& length,
                                              ChasedLength rule) {
  return std::make_unique<Chase>(bones, length, rule);
}

}  // namespace backbend::validate
