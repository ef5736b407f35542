#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "solver/systems/snake.h"
#include "validate/prove/claim_checker.h"
#include "validate/prove/moving_curve.h"
#include "validate/prove/moving_pose.h"
#include "validate/prove/proof.h"

namespace backbend::validate {
namespace {

using solver::Interval;

/// Joints walked along a uniform cubic B-spline from its start; their frames are carried along its
/// tangents and rolled by a twist that is straight between keys.
///
/// A step between controls is turned in its control's frame by its share of extension about X and
/// then of side about Y.
class SnakeChecker final : public ClaimChecker {
 public:
  SnakeChecker(const ProofQuestion& q, const solver::SpineSystem& system)
      : rest_(solver::snake_at_rest(q.rig, q.chain)),
        spread_(q.mapping == solver::Mapping::spread) {
    // Without a key at an end, the twist there is none.
    const auto& keys = std::get<std::vector<double>>(system.options().at("twist_u"));
    if (keys.empty() || keys.front() > 0.0) key_.push_back({0.0, 0.0});
    for (const double at : keys) key_.push_back({at, share(at)});
    if (key_.back().at < 1.0) key_.push_back({1.0, 0.0});
    varies_ = varying_channels(q.box);

    const int joints = static_cast<int>(std::get<double>(system.options().at("joints")));
    const MovingChannels still{SubBox{}};
    const MovingCurve curve = curve_over(still, 512);
    const glm::dmat3 axes(1.0);
    std::optional from = curve.start();
    for (int k = 1; k < joints; ++k) {
      const auto to = curve.share(k, joints - 1);
      if (!to) throw ProofError("snake: the checker cannot enclose the joints at rest");
      bone_.push_back(size(curve.way(*from, *to, axes)).center);
      from = to;
    }
  }

  /// Bounds hardly depend on the twist: it counts only where joints slide between its keys.
  std::array<bool, kProofAxes> idle() const override { return {false, false, true}; }

  double gain_over(const SubBox& part) const override {
    constexpr double kInfinite = std::numeric_limits<double>::infinity();
    const MovingChannels channels(part);
    const MovingCurve curve = curve_over(channels, 0);
    const glm::dmat3& first = rest_.front().frame;  // side, up, along the path
    glm::dmat3 axes(first[2], first[0], first[1]);
    MovingFrame frame(axes[0], channels.reach);
    std::optional<MovingCurve::Place> joint = curve.start();
    double most = 0.0;
    for (std::size_t k = 0;; ++k) {
      axes = axes_along(curve.velocity_about(*joint), axes);
      if (!frame.go(axes, curve.velocity(*joint, axes))) return kInfinite;
      const MovingNumber twist = twist_at(curve, *joint, channels.angle[2]);
      most = std::max(most, frame.fastest(varies_, twist.by));
      if (k == bone_.size()) return most * (1.0 + 1e-12);
      joint = curve.step(*joint, MovingNumber(bone_[k]), axes);
      if (!joint) return kInfinite;
    }
  }

 private:
  /// What a place on the body, 0 tail to 1 head, has of a bend or twist of the whole.
  Interval share(const Interval& at) const {
    if (spread_) return at;
    const Interval upper = Interval(2.0) * at - Interval(1.0);
    return {std::max(upper.lo, 0.0), std::max(upper.hi, 0.0)};
  }

  struct Key {
    double at;
    Interval share;
  };

  MovingCurve curve_over(const MovingChannels& channels, int panels) const {
    std::vector<MovingVector> step;
    const Interval last(double(rest_.size() - 2));
    for (std::size_t i = 1; i < rest_.size(); ++i) {
      const Interval own = share(Interval(double(i - 1)) / last);
      const std::array<MovingNumber, 3> bend = {-own * channels.angle[0], own * channels.angle[1],
                                                MovingNumber(Interval(0.0))};
      const MovingVector way(fixed(rest_[i].position) - fixed(rest_[i - 1].position));
      step.push_back(turned(rest_[i].frame, bend, way));
      sharpen(step.back(), channels.reach);
    }
    return MovingCurve(step, channels.reach, panels);
  }

  /// The twist of a joint's frame, and how fast it changes, also because the joint slides.
  MovingNumber twist_at(const MovingCurve& curve, const MovingCurve::Place& joint,
                        const MovingNumber& twist) const {
    const Interval end = curve.end().u.value;
    const Interval u(std::min(joint.u.value.lo, end.lo), std::min(joint.u.value.hi, end.hi));
    const Interval at = u / end;
    std::optional<MovingNumber> all;
    for (std::size_t i = 1; i < key_.size(); ++i) {
      const Key &from = key_[i - 1], &to = key_[i];
      if (at.hi < from.at || at.lo > to.at) continue;
      const Interval slope = (to.share - from.share) / (Interval(to.at) - Interval(from.at));
      const Interval inside(std::max(at.lo, from.at), std::min(at.hi, to.at));
      MovingNumber own = (from.share + (inside - Interval(from.at)) * slope) * twist;
      for (std::size_t j = 0; j < 3; ++j) {
        Interval slides = joint.u.by[j] / end;
        if (joint.u.value.hi > end.lo) slides = hull(slides, 0.0);  // past the end it stands still
        own.by[j] += slope * slides * twist.value;
      }
      if (!all) all = own;
      for (std::size_t j = 0; j < 3; ++j) all->by[j] = hull(all->by[j], own.by[j]);
    }
    if (!all) return MovingNumber(Interval::entire());
    return *all;
  }

  std::vector<solver::PathFrames::Place> rest_;  // of the controls
  std::vector<Interval> bone_;
  std::vector<Key> key_;
  bool spread_;
  std::array<bool, 3> varies_{};
};

}  // namespace

std::unique_ptr<ClaimChecker> snake_checker(const ProofQuestion& q,
                                            const solver::SpineSystem& system) {
  const auto& options = system.options();
  check_body_channels(q);
  if (std::get<std::string>(options.at("closest")) != "walk")
    checker_knows(q, "closest = \"walk\" only");
  if (std::get<double>(options.at("lead")) != 0.0) checker_knows(q, "lead = 0 only");
  return std::make_unique<SnakeChecker>(q, system);
}

}  // namespace backbend::validate
