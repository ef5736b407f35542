#include "validate/metrics/surface/bend_intent.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace backbend::validate {
namespace {

/// A curve given as points at equal arc steps, with the frames that transport along it.
class TransportedCurve {
 public:
  /// `start`: rotation of the frame at the first point; it is swung onto the curve's tangent.
  explicit TransportedCurve(std::span<const glm::dvec3> point) : point_(point) {
    glm::dquat frame(1, 0, 0, 0);
    for (std::size_t i = 0; i < point.size(); ++i) {
      const glm::dvec3 tangent = sample_tangent(i);
      if (i > 0) frame = rotation(arc_between(tangent_.back(), tangent)) * frame;
      tangent_.push_back(tangent);
      frame_.push_back(frame);
    }
  }

  glm::dvec3 at(double s) const {
    const auto [i, share] = place(s);
    return glm::mix(point_[i], point_[i + 1], share);
  }
  glm::dvec3 tangent(double s) const {
    const auto [i, share] = place(s);
    const glm::dvec3 t = glm::mix(tangent_[i], tangent_[i + 1], share);
    const double length = glm::length(t);
    return length > 0.0 ? t / length : t;
  }
  /// Rotation that carries directions from the first point to s without twist.
  glm::dquat transport(double s) const {
    const auto [i, share] = place(s);
    return rotation(turn_between(frame_[i], frame_[i + 1]) * share) * frame_[i];
  }
  /// Turning per arc fraction around s, over the part of a window that is on the curve: half of it
  /// or more on the curve itself; beyond its end, where nothing turns, it runs out to 0.
  glm::dvec3 turning(double s, double window) const {
    const double low = std::clamp(s - 0.5 * window, 0.0, 1.0);
    const double high = std::clamp(s + 0.5 * window, 0.0, 1.0);
    if (!(high > low)) return glm::dvec3(0.0);
    return arc_between(tangent(low), tangent(high)) / std::max(high - low, 0.5 * window);
  }

 private:
  struct Place {
    std::size_t sample;
    double share;
  };
  Place place(double s) const {
    const double at = std::clamp(s, 0.0, 1.0) * static_cast<double>(point_.size() - 1);
    const std::size_t i = std::min(static_cast<std::size_t>(at), point_.size() - 2);
    return {i, at - static_cast<double>(i)};
  }
  glm::dvec3 sample_tangent(std::size_t i) const {
    const glm::dvec3 step = point_[std::min(i + 1, point_.size() - 1)] - point_[i == 0 ? 0 : i - 1];
    const double length = glm::length(step);
    if (length > 0.0) return step / length;
    return tangent_.empty() ? glm::dvec3(0, 1, 0) : tangent_.back();
  }

  std::span<const glm::dvec3> point_;
  std::vector<glm::dvec3> tangent_;
  std::vector<glm::dquat> frame_;
};

}  // namespace

BendIntent bend_intent(const SpineSlices& slices, const SlicePose& rest, const IntentInput& in) {
  assert(in.intended.size() >= 2 && in.intended_rest.size() >= 2);
  const TransportedCurve posed(in.intended), at_rest(in.intended_rest);
  // The hip's turn, swung so that it takes rest's first tangent to the posed one.
  const glm::dvec3 carried = in.pose.hip.turn * at_rest.tangent(0.0);
  const glm::dquat start = rotation(arc_between(carried, posed.tangent(0.0))) * in.pose.hip.turn;
  const auto untwisted = [&](double s) {
    return posed.transport(s) * start * glm::conjugate(at_rest.transport(s));
  };
  // What twist is missing at the chest, with the full turns that were asked for.
  const glm::dvec3 end_tangent = posed.tangent(1.0);
  const double principal =
      twist_about(in.pose.chest.turn * glm::conjugate(untwisted(1.0)), end_tangent);
  const double twist = principal + 2.0 * kPi * std::round((in.twist - principal) / (2.0 * kPi));

  BendIntent out;
  for (std::size_t r = 0; r < slices.slice.size(); ++r) {
    const double s = slices.slice[r].s;
    const glm::dquat frame = rotation(posed.tangent(s) * (twist * std::min(s, 1.0))) * untwisted(s);
    out.frame.push_back(frame);
    out.rest_tangent.push_back(at_rest.tangent(s));
    out.centre.push_back(posed.at(s) + frame * (rest.centre[r] - at_rest.at(s)));
    out.bend.push_back(
        (glm::conjugate(frame) * posed.turning(s, in.window) - at_rest.turning(s, in.window)) /
        slices.spine_length);
  }
  out.twist = twist / slices.spine_length;
  out.stretch = in.stretch;
  return out;
}

BendIntent no_intent(const SpineSlices& slices, const SlicePose& rest,
                     const solver::RigidMotion& moved) {
  BendIntent out;
  const std::size_t n = slices.slice.size();
  out.rest_tangent.assign(n, glm::dvec3(0, 1, 0));
  out.frame.assign(n, moved.turn);
  for (std::size_t r = 0; r < n; ++r) out.centre.push_back(moved.apply(rest.centre[r]));
  out.bend.assign(n, glm::dvec3(0.0));
  return out;
}

}  // namespace backbend::validate
