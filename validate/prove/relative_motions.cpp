#include "validate/prove/relative_motions.h"

namespace backbend::validate {

using solver::BoxTurn;
using solver::BoxVector;
using solver::Interval;
using solver::IntervalVector;

namespace {

IntervalVector exactly(const glm::dvec3& v) { return {v.x, v.y, v.z}; }

}  // namespace

RelativeMotions::RelativeMotions(std::span<const solver::BoxMotion> motions,
                                 std::span<const MotionPair> pairs) {
  for (const MotionPair& pair : pairs) {
    const solver::BoxMotion &base = motions[pair.base], &motion = motions[pair.motion];
    Relative r{};
    r.same = pair.base == pair.motion;
    if (!r.same) {
      const BoxTurn back = conjugate(base.turn), turn = back * motion.turn;
      for (std::size_t i = 0; i < 3; ++i) {
        glm::dvec3 axis(0.0);
        axis[glm::length_t(i)] = 1.0;
        r.box_excess[i] = turn * BoxVector(axis) - BoxVector(axis);
        r.excess[i] = r.box_excess[i].value();
      }
      r.origin = motion.rest_origin;
      r.box_way = back * (motion.posed_origin - base.posed_origin) -
                  BoxVector(motion.rest_origin - base.rest_origin);
      r.way = r.box_way.value();
    }
    relative_.push_back(r);
  }
}

IntervalVector RelativeMotions::turn(std::size_t pair, const glm::dvec3& v) const {
  const Relative& r = relative_[pair];
  if (r.same) return exactly(v);
  return exactly(v) +
         (Interval(v.x) * r.excess[0] + Interval(v.y) * r.excess[1] + Interval(v.z) * r.excess[2]);
}

IntervalVector RelativeMotions::shift(std::size_t pair, const glm::dvec3& point) const {
  const Relative& r = relative_[pair];
  if (r.same) return {};
  const glm::dvec3 v = point - r.origin;
  return r.way +
         (Interval(v.x) * r.excess[0] + Interval(v.y) * r.excess[1] + Interval(v.z) * r.excess[2]);
}

BoxVector RelativeMotions::box_shift(std::size_t pair, const glm::dvec3& point) const {
  const Relative& r = relative_[pair];
  BoxVector shift = r.box_way;
  for (std::size_t i = 0; i < 3; ++i) {
    const double along = (point - r.origin)[static_cast<glm::length_t>(i)];
    shift = shift + solver::BoxReal(along) * r.box_excess[i];
  }
  return shift;
}

}  // namespace backbend::validate
