#include "validate/metrics/clip_flip.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

namespace backbend::validate {
namespace {

double median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Everything about one joint of a clip.
class JointMotion {
 public:
  JointMotion(const ClipMotion& clip, std::size_t joint, const ClipSettings& settings)
      : settings_(settings) {
    const std::size_t frames = clip.time.size();
    for (std::size_t f = 0; f + 1 < frames; ++f) {
      const glm::dquat& from = clip.turn[f * clip.joint_count + joint];
      const glm::dquat& to = clip.turn[(f + 1) * clip.joint_count + joint];
      duration_.push_back(clip.time[f + 1] - clip.time[f]);
      step_.push_back(turn_between(from, to));
    }
    const std::size_t n = step_.size();
    change_.assign(n, 0.0);
    for (std::size_t f = 0; f < n; ++f) change_[f] = change(f);
  }

  std::size_t steps() const { return step_.size(); }

  /// How much a step turns beyond what its neighbours' pace explains, radians.
  double change_at(std::size_t step) const { return change_[step]; }

  /// The largest change that the motion around a step explains, radians.
  double explained(std::size_t step) const {
    std::vector<double> around;
    const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(step_.size());
    const std::ptrdiff_t at = static_cast<std::ptrdiff_t>(step);
    for (std::ptrdiff_t f = at - settings_.reach; f <= at + settings_.reach; ++f)
      if (f >= 0 && f < n && std::abs(f - at) > 1) around.push_back(change_[f]);
    return std::max(radians_from(settings_.smallest_deg), settings_.outlier * median(around));
  }

 private:
  double change(std::size_t f) const {
    const auto pace = [&](std::size_t k) { return step_[k] / duration_[k]; };
    const auto beyond = [&](const glm::dvec3& expected) {
      return glm::length(step_[f] - expected * duration_[f]);
    };
    // The first and last step have neighbours on one side only: a jump in one of them is no reason
    // to suspect this one, so the nearer of the two paces counts.
    const std::size_t last = step_.size() - 1;
    if (f == 0) return std::min(beyond(pace(1)), beyond(pace(2)));
    if (f == last) return std::min(beyond(pace(last - 1)), beyond(pace(last - 2)));
    return beyond(0.5 * (pace(f - 1) + pace(f + 1)));
  }

  const ClipSettings& settings_;
  std::vector<glm::dvec3> step_;
  std::vector<double> duration_, change_;
};

}  // namespace

ClipReport find_clip_flips(const ClipMotion& clip, const ClipSettings& settings) {
  assert(clip.turn.size() == clip.time.size() * clip.joint_count);
  ClipReport out;
  for (std::size_t i = 0; i < clip.turn.size(); ++i)
    if (!is_finite(clip.turn[i])) {
      out.finite = false;
      out.not_finite_frame = i / clip.joint_count;
      return out;
    }
  out.detectable_deg.assign(clip.joint_count, std::numeric_limits<double>::infinity());
  if (clip.time.size() < 5) return out;
  for (std::size_t joint = 0; joint < clip.joint_count; ++joint) {
    const JointMotion motion(clip, joint, settings);
    double detectable = 0.0;
    for (std::size_t f = 0; f < motion.steps(); ++f) {
      const double explained = motion.explained(f);
      detectable = std::max(detectable, explained);
      const double change = motion.change_at(f);
      // A jump shows half its size in the steps beside it: only the peak is one.
      const bool peak = (f == 0 || change > motion.change_at(f - 1)) &&
                        (f + 1 == motion.steps() || change >= motion.change_at(f + 1));
      if (peak && change > explained)
        out.jumps.push_back({joint, f, degrees(change), degrees(explained)});
    }
    out.detectable_deg[joint] = degrees(detectable);
  }
  std::ranges::stable_sort(out.jumps, {}, &ClipJump::frame);
  return out;
}

}  // namespace backbend::validate
