#include "validate/prove/moving_pose.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <limits>

#include "validate/prove/proof.h"

namespace backbend::validate {

using solver::Interval;

std::array<MovingNumber, 3> MovingChannels::chest_swing(double part) const {
  return {MovingNumber(Interval(0.0)), Interval(-part) * angle[1], Interval(-part) * angle[0]};
}

MovingChannels::MovingChannels(const SubBox& part) {
  const Interval degree = solver::kPiInterval / Interval(180.0);
  for (std::size_t j = 0; j < 3; ++j) {
    const Interval range(part.low[j], part.high[j]);
    const Interval middle(range.middle());
    angle[j] = {range * degree, middle * degree, {}};
    angle[j].by[j] = 1.0;
    reach[j] = (range - middle) * degree;
  }
}

std::array<bool, 3> varying_channels(const ProofBox& box) {
  return {box.axis[0].varies(), box.axis[1].varies(), box.axis[2].varies()};
}

glm::dmat3 axes_of(const glm::dvec3& bone, const glm::dvec3& left) {
  const glm::dvec3 x = glm::normalize(bone), across = left - glm::dot(left, x) * x;
  if (!(glm::length(across) > 1e-5 * glm::length(left)))
    throw ProofError("the checker does not know spines with a bone that points to the left");
  const glm::dvec3 z = glm::normalize(across);
  return {x, glm::cross(z, x), z};
}

Vec fixed(const glm::dvec3& v) { return {v.x, v.y, v.z}; }

namespace {

template <class Change>
MovingVector each_part(const MovingVector& v, const Change& change) {
  return {change(v.value), change(v.center), {change(v.by[0]), change(v.by[1]), change(v.by[2])}};
}

Vec turned_by(const Vec& v, std::size_t axis, const Interval& angle) {
  const std::size_t a = (axis + 1) % 3, b = (axis + 2) % 3;
  const Interval c = cosine(angle), s = sine(angle);
  Vec out = v;
  out[a] = c * v[a] - s * v[b];
  out[b] = s * v[a] + c * v[b];
  return out;
}

}  // namespace

MovingVector from_axes(const glm::dmat3& axes, const MovingVector& v) {
  return each_part(v, [&](const Vec& on) {
    return on[0] * fixed(axes[0]) + on[1] * fixed(axes[1]) + on[2] * fixed(axes[2]);
  });
}

Vec on_axes(const glm::dmat3& axes, const Vec& v) {
  return {dot(v, fixed(axes[0])), dot(v, fixed(axes[1])), dot(v, fixed(axes[2]))};
}

MovingVector on_axes(const glm::dmat3& axes, const MovingVector& v) {
  return each_part(v, [&](const Vec& part) { return on_axes(axes, part); });
}

MovingVector turned(const MovingVector& v, std::size_t axis, const MovingNumber& angle) {
  MovingVector out =
      each_part(v, [&](const Vec& part) { return turned_by(part, axis, angle.value); });
  out.center = turned_by(v.center, axis, angle.center);
  Vec about{};
  about[axis] = 1.0;
  for (std::size_t j = 0; j < 3; ++j) out.by[j] = out.by[j] + angle.by[j] * cross(about, out.value);
  return out;
}

MovingVector turned(const glm::dmat3& axes, const std::array<MovingNumber, 3>& euler,
                    const MovingVector& v) {
  MovingVector out = on_axes(axes, v);
  for (std::size_t axis = 0; axis < 3; ++axis) out = turned(out, axis, euler[axis]);
  return from_axes(axes, out);
}

glm::dmat3 axes_along(const glm::dvec3& x, const glm::dmat3& like) {
  const glm::dvec3 along = glm::normalize(x);
  // Of the other two, the one that is farther from x is kept.
  const bool second = std::abs(glm::dot(along, like[1])) < std::abs(glm::dot(along, like[2]));
  const glm::dvec3 kept = like[second ? 1 : 2];
  const glm::dvec3 across = glm::normalize(kept - glm::dot(kept, along) * along);
  if (second) return {along, across, glm::cross(along, across)};
  return {along, glm::cross(across, along), across};
}

namespace {

/// The joints at the ends of the three bones: the chain's own, or the thirds of its length.
std::array<glm::dvec3, 4> three_bones_of(const std::vector<glm::dvec3>& joint) {
  if (joint.size() == 4) return {joint[0], joint[1], joint[2], joint[3]};
  double whole = 0.0;
  for (std::size_t k = 1; k < joint.size(); ++k) whole += glm::distance(joint[k - 1], joint[k]);
  const auto at = [&](double left) {
    std::size_t k = 1;
    for (; k + 1 < joint.size() && glm::distance(joint[k - 1], joint[k]) < left; ++k)
      left -= glm::distance(joint[k - 1], joint[k]);
    return glm::mix(joint[k - 1], joint[k], left / glm::distance(joint[k - 1], joint[k]));
  };
  return {joint.front(), at(whole / 3.0), at(2.0 * whole / 3.0), joint.back()};
}

}  // namespace

MovingSpine::MovingSpine(const ProofQuestion& q) : spread_(q.mapping == solver::Mapping::spread) {
  const auto joint = three_bones_of(q.chain.joint);
  for (std::size_t k = 0; k < 3; ++k) {
    axes_[k] = axes_of(joint[k + 1] - joint[k], q.chain.left);
    rest_[k] = Vec(glm::distance(joint[k], joint[k + 1]) * fixed(axes_[k][0]));
  }
}

std::array<MovingVector, 3> MovingSpine::bones(const MovingChannels& channels) const {
  const double part = spread_ ? 0.5 : 1.0;
  // A control's own X leaves its bone where it is.
  const std::array<MovingNumber, 3> swing = channels.chest_swing(part);
  std::array<MovingNumber, 3> turn = swing;
  turn[0] = Interval(part) * channels.angle[2];
  std::array<MovingVector, 3> bone = {MovingVector(rest_[0]), MovingVector(rest_[1]),
                                      turned(axes_[2], swing, MovingVector(rest_[2]))};
  if (spread_) {
    bone[1] = turned(axes_[1], swing, bone[1]);
    bone[2] = turned(axes_[1], turn, bone[2]);
  }
  for (MovingVector& each : bone) sharpen(each, channels.reach);
  return bone;
}

std::array<MovingVector, 3> MovingSpine::moves(const MovingChannels& channels) const {
  std::array<MovingVector, 3> moved = bones(channels);
  for (std::size_t k = 0; k < 3; ++k) moved[k] = moved[k] - MovingVector(rest_[k]);
  return moved;
}

HipChestLegs::HipChestLegs(const ProofQuestion& q, const std::vector<double>& depth)
    : spine_(q), depth_(depth) {
  const glm::dvec3 way = q.chain.joint.back() - q.chain.joint.front();
  axes_ = axes_of(way, q.chain.left);
  length_ = glm::length(way);
}

std::vector<MovingVector> HipChestLegs::over(const MovingChannels& channels) const {
  const MovingVector along(Interval(length_) * fixed(axes_[0]));
  const MovingVector first = Interval(depth_[0]) * along;
  MovingVector last = Interval(depth_[1]) * turned(axes_, channels.chest_swing(1.0), along);
  sharpen(last, channels.reach);
  MovingVector middle = along - first - last;
  if (spine_.spread()) {
    // The chest is where the tip of three bones would be that share the bend.
    for (const MovingVector& moved : spine_.moves(channels)) middle = middle + moved;
    sharpen(middle, channels.reach);
  }
  return {first, middle, last};
}

MovingVector unit(const MovingVector& v) {
  MovingVector out(unit(v.value), unit(v.center), {});
  const Interval per_length = Interval(1.0) / size(v.value);
  for (std::size_t j = 0; j < 3; ++j) {
    Vec& by = out.by[j];
    by = per_length * (v.by[j] - dot(out.value, v.by[j]) * out.value);
    // A unit vector does not move along itself, which is nearly the first axis.
    by[0] = common(by[0], -((out.value[1] * by[1] + out.value[2] * by[2]) / out.value[0]));
  }
  return out;
}

bool MovingFrame::go(const glm::dmat3& axes, const MovingVector& bone) {
  bone_ = on_axes(glm::transpose(axes_) * axes, bone_);
  axes_ = axes;
  MovingVector next = unit(bone);
  sharpen(next, reach_);
  MovingVector across = cross(next, bone_);
  sharpen(across, reach_);
  const Interval both = Interval(1.0) + dot(next.value, bone_.value);
  if (!(both.lo > 0.1)) return false;
  for (std::size_t j = 0; j < 3; ++j)
    roll_[j] += dot(across.value, next.by[j] + bone_.by[j]) / both;
  bone_ = next;
  return true;
}

Interval MovingFrame::rate(std::size_t channel, const Interval& more) const {
  return square_root(square(roll_[channel] + more) + size_squared(bone_.by[channel]));
}

double MovingFrame::fastest(const std::array<bool, 3>& varies,
                            const std::array<Interval, 3>& more) const {
  double most = 0.0;
  for (std::size_t j = 0; j < 3; ++j) {
    if (!varies[j]) continue;
    const Interval own = rate(j, more[j]);
    most = std::max(most, own.is_finite() ? own.hi : std::numeric_limits<double>::infinity());
  }
  return most;
}

}  // namespace backbend::validate
