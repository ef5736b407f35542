#include "solver/curves/box_tangents.h"

#include <algorithm>

namespace backbend::solver {
namespace {

IntervalVector hull(const IntervalVector& a, const IntervalVector& b) {
  return {hull(a.x, b.x), hull(a.y, b.y), hull(a.z, b.z)};
}

void set_slope(BoxVector& v, std::size_t j, const IntervalVector& slope) {
  v.x.slope[j] = slope.x;
  v.y.slope[j] = slope.y;
  v.z.slope[j] = slope.z;
}

IntervalVector common(const IntervalVector& a, const IntervalVector& b) {
  return {common(a.x, b.x), common(a.y, b.y), common(a.z, b.z)};
}

BoxVector narrowed(const BoxVector& v) { return {narrowed(v.x), narrowed(v.y), narrowed(v.z)}; }

using Pieces = std::vector<std::array<BoxVector, 4>>;

/// The pieces, each from where the one before it ends.
Pieces pieces_of(const std::vector<BoxTangents::Legs>& piece) {
  Pieces drawn;
  BoxVector end(glm::dvec3(0.0));
  for (const BoxTangents::Legs& legs : piece) {
    std::array<BoxVector, 4> cv{end};
    for (std::size_t i = 0; i < 3; ++i) cv[i + 1] = cv[i] + legs[i];
    end = cv[3];
    drawn.push_back(cv);
  }
  return drawn;
}

/// The same at the box's middle.
Pieces middle_of(Pieces drawn) {
  for (auto& cvs : drawn) {
    for (BoxVector& cv : cvs)
      cv = {BoxReal(cv.x.center), BoxReal(cv.y.center), BoxReal(cv.z.center)};
  }
  return drawn;
}

BoxVector mean_on(const BoxCurve& curve, double from, double to) {
  const BoxReal arc = BoxReal(Interval(to) - Interval(from)) * curve.length();
  return (curve.point_at_share(to) - curve.point_at_share(from)) / arc;
}

BoxReal common(BoxReal a, const BoxReal& b) {
  a.center = common(a.center, b.center);
  for (std::size_t j = 0; j < kBoxVariables; ++j) a.slope[j] = common(a.slope[j], b.slope[j]);
  return narrowed(a);
}

}  // namespace

BoxTangents::BoxTangents(const std::vector<Legs>& piece, int panels)
    : length_(0.0), end_(unit(piece.back()[2])), middle_(middle_of(pieces_of(piece)), panels) {
  std::vector<BoxArc> arc;
  std::vector<BoxReal> before;
  for (const Legs& legs : piece) {
    arc.emplace_back(legs, panels);
    before.push_back(length_);
    length_ = length_ + arc.back().length();
  }
  finite_ = length_.is_finite();
  if (!finite_) return;
  constexpr double kNearlyOnePose = 1e-4;
  constexpr int kFinePanels = 64;
  if (length_.value.width() < kNearlyOnePose * length_.value.lo)
    whole_.emplace(pieces_of(piece), kFinePanels);
  BoxReal after(0.0);
  std::vector<BoxReal> behind(piece.size());
  for (std::size_t p = piece.size(); p-- > 0;) {
    behind[p] = after;
    after = arc[p].length() + after;
  }
  for (std::size_t p = 0; p < piece.size(); ++p)
    add_panels(piece[p], arc[p], double(p), before[p], behind[p]);
  for (std::size_t j = 0; j < kBoxVariables; ++j)
    most_turn_[j] = std::max(most_turn_[j], solver::length(end_.slope(j)).hi);
}

void BoxTangents::add_panels(const Legs& legs, const BoxArc& arc, double number,
                             const BoxReal& before, const BoxReal& after) {
  const int panels = arc.panel_count();
  const BoxReal three(3.0), six(6.0);
  const std::array<BoxVector, 2> turn{six * (legs[1] - legs[0]), six * (legs[2] - legs[1])};
  // The derivative between two parameters, as de Casteljau's scheme has it: on a panel it is a mean
  // of those at both ends and of the one between them.
  const auto velocity = [&](double s, double t) {
    const BoxReal s1(s), s0 = BoxReal(1.0) - s1, t1(t), t0 = BoxReal(1.0) - t1;
    return three * ((s0 * t0) * legs[0] + (s0 * t1 + s1 * t0) * legs[1] + (s1 * t1) * legs[2]);
  };
  const auto change = [&](double t) {
    return (BoxReal(1.0) - BoxReal(t)) * turn[0] + BoxReal(t) * turn[1];
  };
  for (int i = 0; i < panels; ++i) {
    const double from = double(i) / panels, to = double(i + 1) / panels;
    const Interval way = Interval(0.0, (Interval(to) - Interval(from)).hi);
    const BoxVector all = hull(hull(velocity(from, from), velocity(from, to)), velocity(to, to));
    const BoxReal speed = solver::length(all);
    Panel p;
    p.tangent = p.at_share = unit(all);
    p.speed = speed.value;
    const IntervalVector along = p.tangent.value();
    const BoxVector turn = hull(change(from), change(to));
    const BoxVector turned = turn - dot(p.tangent, turn) * p.tangent;
    p.bend = common((turned / square(speed)).value(),
                    Interval(1.0) / (p.speed * p.speed) * across(along, turn.value()));
    p.piece = Interval(number) + Interval(from, to);
    const BoxReal begin = before + arc.until(i), end = before + arc.until(i + 1);
    const BoxReal rest = arc.after(i + 1) + after;
    p.arc = {begin.value.lo, end.value.hi};
    p.share = {(begin / length_).value.lo, (end / length_).value.hi};
    for (std::size_t j = 0; j < kBoxVariables; ++j) {
      const Interval grown = way * dot(along, all.slope(j));
      p.arc_slope[j] = begin.slope[j] + grown;
      const Interval rest_slope = rest.slope[j] + grown;
      const Interval share = common(p.share, Interval(0.0, 1.0));
      const Interval passed = (Interval(1.0) - share) * p.arc_slope[j] - share * rest_slope;
      set_slope(p.at_share, j, p.tangent.slope(j) - passed * p.bend);
    }
    p.at_share = narrowed(p.at_share);
    for (std::size_t j = 0; j < kBoxVariables; ++j) {
      const IntervalVector moved = p.tangent.slope(j) - p.arc_slope[j] * p.bend;
      most_turn_[j] = std::max(most_turn_[j], solver::length(moved).hi);
    }
    const Interval bend = solver::length(p.bend);
    finite_ = finite_ && p.tangent.is_finite() && bend.is_finite() && p.share.is_finite();
    most_bend_ = std::max(most_bend_, bend.hi);
    panel_.push_back(p);
  }
}

BoxStep BoxTangents::mean_between(double from, double to) const {
  const Interval begin(from), way = Interval(to) - begin;
  const BoxVector middle = mean_on(middle_, from, to);
  if (!finite_ || !middle.is_finite()) {
    return {BoxVector::undefined(), BoxReal::undefined().slope};
  }
  // The mean of what the tangent may be on each part of the arc.
  constexpr int kParts = 4;
  BoxVector mean(glm::dvec3(0.0)), everywhere;
  double bend = 0.0;
  for (int q = 0; q < kParts; ++q) {
    const double low = (begin + Interval(double(q) / kParts) * way).lo;
    const double high = (begin + Interval(double(q + 1) / kParts) * way).hi;
    BoxVector part;
    bool first = true;
    for (const Panel& p : panel_) {
      if (p.share.hi < low || p.share.lo > high) continue;
      part = first ? p.at_share : hull(part, p.at_share);
      first = false;
      bend = std::max(bend, solver::length(p.bend).hi);
    }
    everywhere = q == 0 ? part : hull(everywhere, part);
    mean = mean + BoxReal(1.0 / kParts) * part;
  }
  mean.x.center = common(mean.x.center, middle.x.center);
  mean.y.center = common(mean.y.center, middle.y.center);
  mean.z.center = common(mean.z.center, middle.z.center);
  if (whole_) {
    const BoxVector solved = mean_on(*whole_, from, to);
    if (solved.is_finite())
      mean = {common(mean.x, solved.x), common(mean.y, solved.y), common(mean.z, solved.z)};
  }
  // The mean M of unit tangents T: as T . T' = 0, M . M' is the mean over pairs of places of
  // -1/2 (T1 - T2) . (T1' - T2'). The first factor is at most the bend times their distance, of
  // which the mean is a third of the arc; the second is at most as large as all slopes are wide.
  BoxSlopes lengthening;
  const Interval turn = Interval(bend) * way * length_.value;
  for (std::size_t j = 0; j < kBoxVariables; ++j) {
    const IntervalVector all = everywhere.slope(j);
    const double most = (turn * solver::length(all - all) / Interval(6.0)).hi;
    lengthening[j] = {-most, most};
  }
  return {narrowed(mean), lengthening};
}

std::array<bool, kBoxVariables> BoxTangents::still() const {
  constexpr double kNothing = 1e-100;  // roundings of 0 are below it
  std::array<bool, kBoxVariables> still{};
  for (std::size_t j = 0; j < still.size(); ++j)
    still[j] = most_turn_[j] < kNothing && length_.slope[j].most() < kNothing;
  return still;
}

template <class Of>
IntervalVector BoxTangents::panels_over(const Interval& arc, const Of& of) const {
  IntervalVector all{Interval::entire(), Interval::entire(), Interval::entire()};
  bool first = true;
  for (const Panel& p : panel_) {
    if (p.arc.hi < arc.lo || p.arc.lo > arc.hi) continue;
    all = first ? of(p) : hull(all, of(p));
    first = false;
  }
  return all;
}

IntervalVector BoxTangents::tangent_over(const Interval& arc) const {
  const IntervalVector past_end = end_.value();
  if (arc.lo > length_.value.hi) return past_end;
  const IntervalVector all = panels_over(arc, [](const Panel& p) { return p.tangent.value(); });
  return arc.hi > length_.value.lo ? hull(all, past_end) : all;
}

IntervalVector BoxTangents::bend_over(const Interval& arc) const {
  const IntervalVector past_end;
  if (arc.lo > length_.value.hi) return past_end;
  const IntervalVector all = panels_over(arc, [](const Panel& p) { return p.bend; });
  return arc.hi > length_.value.lo ? hull(all, past_end) : all;
}

std::optional<BoxTangents::Joint> BoxTangents::walked(const Joint& from, double bone) const {
  constexpr double kMostTurn = 1.0;
  // asin(x) is at most x (1 + (pi / 2 - 1) x^2) up to 1.
  const Interval chord(bone), bend(most_bend_), half = Interval(0.5) * bend * chord;
  const Interval longest = chord * (Interval(1.0) + Interval(0.571) * square(half));
  const Interval turn = bend * longest, way(chord.lo, longest.hi);
  if (!(turn.hi < kMostTurn)) return std::nullopt;
  Joint to;
  to.arc = from.arc + way;
  to.turned = way * bend_over(hull(from.arc, to.arc));
  for (std::size_t j = 0; j < kBoxVariables; ++j) {
    const Interval slid = longest * turn * Interval(most_turn_[j]);
    const double most = ((Interval(from.slope[j].most()) + slid) / cosine(turn)).hi;
    to.slope[j] = {-most, most};
  }
  return to;
}

BoxTangents::Place BoxTangents::at(const Joint& joint) const {
  const Interval& arc = joint.arc;
  Place place;
  auto join = [&, first = true](const BoxVector& tangent, const BoxReal& piece) mutable {
    place.tangent = first ? tangent : hull(place.tangent, tangent);
    place.piece = first ? piece : hull(place.piece, piece);
    first = false;
  };
  for (const Panel& p : panel_) {
    if (p.arc.hi < arc.lo || p.arc.lo > arc.hi) continue;
    // The tangent moves with the curve, and with the place on it.
    BoxVector tangent = p.tangent;
    BoxReal piece(p.piece);
    for (std::size_t j = 0; j < kBoxVariables; ++j) {
      const Interval passed = joint.slope[j] - p.arc_slope[j];
      set_slope(tangent, j, tangent.slope(j) + passed * p.bend);
      piece.slope[j] = passed / p.speed;
    }
    join(narrowed(tangent), piece);
  }
  if (arc.hi > length_.value.lo) join(end_, BoxReal(panel_.back().piece.hi));
  return place;
}

BoxTangents bezier_tangents(const std::array<BoxVector, 4>& cv, int panels) {
  return BoxTangents({{cv[1] - cv[0], cv[2] - cv[1], cv[3] - cv[2]}}, panels);
}

std::vector<BoxTangents::Legs> bspline_legs(const std::vector<BoxVector>& step) {
  const int spans = int(step.size()) - 2;
  const auto knot = [&](int i) { return std::clamp(double(i - 3), 0.0, double(spans)); };
  // The derivative is a quadratic B-spline on the same knots.
  std::vector<BoxVector> velocity;
  for (int i = 0; i < int(step.size()); ++i)
    velocity.push_back(BoxReal(3.0) * step[std::size_t(i)] / BoxReal(knot(i + 4) - knot(i + 1)));
  const BoxReal third = BoxReal(1.0) / BoxReal(3.0);
  std::vector<BoxTangents::Legs> piece;
  for (int k = 0; k < spans; ++k) {
    const BoxVector* own = &velocity[std::size_t(k)];
    const auto between = [&](int i, const BoxVector& a, const BoxVector& b) {
      const BoxReal whole(knot(i + 1) - knot(i - 1));
      return (BoxReal(knot(i + 1) - knot(i)) * a + BoxReal(knot(i) - knot(i - 1)) * b) / whole;
    };
    piece.push_back({third * between(k + 3, own[0], own[1]), third * own[1],
                     third * between(k + 4, own[1], own[2])});
  }
  return piece;
}

}  // namespace backbend::solver
