#include "solver/curves/box_curve.h"

#include "solver/math/bezier.h"

namespace backbend::solver {
namespace {

BoxVector undefined_point() {
  return {BoxReal::undefined(), BoxReal::undefined(), BoxReal::undefined()};
}

}  // namespace

BoxCurve::BoxCurve(std::vector<std::array<BoxVector, 4>> piece, int panels)
    : piece_(std::move(piece)), length_(0.0) {
  for (const auto& cv : piece_) {
    arc_.emplace_back(cv, panels);
    before_.push_back(length_);
    length_ = length_ + arc_.back().length();
  }
  after_.assign(piece_.size(), BoxReal(0.0));
  for (std::size_t p = piece_.size() - 1; p-- > 0;)
    after_[p] = after_[p + 1] + arc_[p + 1].length();
}

BoxReal BoxCurve::parameter(std::size_t piece, double share) const {
  return arc_[piece].parameter_at_share(share, before_[piece], after_[piece]);
}

BoxVector BoxCurve::point_at_share(double share) const {
  if (share <= 0.0) return start();
  if (share >= 1.0) return end();
  if (!length_.is_finite()) return undefined_point();
  const double goal = share * length_.center.middle();
  std::size_t p = 0;
  while (p + 1 < piece_.size() && before_[p + 1].center.middle() < goal) ++p;
  BoxReal u = parameter(p, share);
  if (!u.is_finite()) return undefined_point();
  const bool goes_below = p > 0 && u.value.lo < 0.0;
  const bool goes_past = p + 1 < piece_.size() && u.value.hi > 1.0;
  if (goes_below && goes_past) return undefined_point();
  if (!goes_below && !goes_past) return bezier_point(piece_[p], u);
  if (goes_below) u = parameter(--p, share);
  const BoxReal next = parameter(p + 1, share);
  if (!u.is_finite() || !next.is_finite() || u.value.lo < 0.0 || next.value.hi > 1.0)
    return undefined_point();
  const BoxReal on = -smaller(-next, 0.0);  // not before the piece begins
  // From its begin: a point is the begin and the mean velocity times the parameter.
  return bezier_point(piece_[p], smaller(u, 1.0)) +
         on * bezier_chord(piece_[p + 1], BoxReal(0.0), on);
}

BoxReal BoxStep::length() const {
  BoxReal size = solver::length(way);
  for (std::size_t j = 0; j < kBoxVariables; ++j)
    size.slope[j] = common(size.slope[j], lengthening[j] / size.value);
  return narrowed(size);
}

void BoxChase::go(const BoxStep& step, const BoxReal& bone) {
  const BoxVector way = step.way - past_ * aim_;
  BoxReal distance = length(way);
  BoxVector aim = way / distance;
  const IntervalVector along = aim.value(), before = aim_.value();
  const Interval kept = dot(along, before);
  const IntervalVector aside = across(along, before);
  for (std::size_t j = 0; j < kBoxVariables; ++j) {
    // The way's slope in its parts: that of past_ turns up once, along the bone and across it.
    const IntervalVector step_moved = step.way.slope(j), aim_moved = past_.value * aim_.slope(j);
    const IntervalVector moved = step_moved - aim_moved;
    // along = (step - past_ aim_) / distance
    const Interval lengthened =
        (step.lengthening[j] - past_.value * dot(before, step_moved)) / distance.value;
    distance.slope[j] = common(distance.slope[j], dot(along, moved) - past_.slope[j] * kept);
    distance.slope[j] =
        common(distance.slope[j], lengthened - dot(along, aim_moved) - past_.slope[j] * kept);
    const IntervalVector turned = across(along, moved) - past_.slope[j] * aside;
    aim.x.slope[j] = common(aim.x.slope[j], turned.x / distance.value);
    aim.y.slope[j] = common(aim.y.slope[j], turned.y / distance.value);
    aim.z.slope[j] = common(aim.z.slope[j], turned.z / distance.value);
  }
  past_ = bone - narrowed(distance);
  aim_ = {narrowed(aim.x), narrowed(aim.y), narrowed(aim.z)};
}

}  // namespace backbend::solver
