#include "validate/metrics/surface/slice_metrics.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <optional>

#include "validate/metrics/math/nan.h"

namespace backbend::validate {
namespace {

constexpr int kReach = kDirectionReach;

/// Direction of the centres around each slice; NaN where one of them is missing.
std::vector<glm::dvec3> directions(const std::vector<glm::dvec3>& centre) {
  const int n = static_cast<int>(centre.size());
  std::vector<glm::dvec3> out(centre.size(), kNowhere);
  for (int r = kReach; r + kReach < n; ++r) {
    const glm::dvec3 step = centre[r + kReach] - centre[r - kReach];
    const double length = glm::length(step);
    if (length > 0.0) out[r] = step / length;
  }
  return out;
}

/// Turning over a window around each slice.
std::vector<glm::dvec3> turnings(const std::vector<glm::dvec3>& direction, int window) {
  const int n = static_cast<int>(direction.size()), below = window / 2, above = window - below;
  std::vector<glm::dvec3> out(direction.size(), kNowhere);
  for (int r = below; r + above < n; ++r)
    if (is_finite(direction[r - below]) && is_finite(direction[r + above]))
      out[r] = arc_between(direction[r - below], direction[r + above]);
  return out;
}

/// |value - mean of the values one window below and above|, in degrees.
template <typename Value, typename Size>
std::vector<double> second_difference(const std::vector<Value>& value, int window, Size size) {
  const int n = static_cast<int>(value.size());
  std::vector<double> out(value.size(), kNan);
  for (int r = window; r + window < n; ++r)
    out[r] = degrees(size(value[r] - 0.5 * (value[r - window] + value[r + window])));
  return out;
}

struct Worst {
  double value = kNan;
  int slice = -1;
};
Worst largest(const std::vector<double>& profile) {
  Worst out;
  for (std::size_t r = 0; r < profile.size(); ++r)
    if (!std::isnan(profile[r]) && !(profile[r] <= out.value))
      out = {profile[r], static_cast<int>(r)};
  return out;
}

/// Twist of each slice's own direction against that of the next, transported along the centres:
/// signed, in (-pi, pi].
std::vector<double> twist_steps(const SlicePose& pose, const std::vector<glm::dvec3>& direction) {
  std::vector<double> out(direction.size(), kNan);
  for (std::size_t k = 0; k + 1 < direction.size(); ++k) {
    if (!is_finite(direction[k]) || !is_finite(direction[k + 1])) continue;
    const glm::dvec3& to = direction[k + 1];
    const glm::dvec3 carried =
        rotation(arc_between(direction[k], to)) *
        (pose.direction[k] - glm::dot(pose.direction[k], direction[k]) * direction[k]);
    const glm::dvec3 own = pose.direction[k + 1] - glm::dot(pose.direction[k + 1], to) * to;
    out[k] = std::atan2(glm::dot(to, glm::cross(carried, own)), glm::dot(carried, own));
  }
  return out;
}

/// The same over a window: slice by slice, so that each step's swing is small and transport follows
/// the bend.
std::vector<double> twists(const SlicePose& pose, const std::vector<glm::dvec3>& direction,
                           int window) {
  const std::vector<double> step = twist_steps(pose, direction);
  const int n = static_cast<int>(direction.size()), below = window / 2, above = window - below;
  std::vector<double> out(direction.size(), kNan);
  for (int r = below; r + above < n; ++r) {
    out[r] = 0.0;
    for (int k = r - below; k < r + above; ++k) out[r] += step[k];
  }
  return out;
}

constexpr double kLeastAlong = 0.25;  // cosine of a step to its slices' normal at rest

/// The step of a line from a slice to the next one at rest, where the surface goes on between them
/// along the body; a step that runs around the body (a brow, a jaw) turns about in any bend.
std::optional<glm::dvec3> forward_step(const SpineSlices& slices, const SlicePose& rest,
                                       std::size_t slice, std::size_t line) {
  const Slice &below = slices.slice[slice], &above = slices.slice[slice + 1];
  if (below.ring.empty() || above.ring.empty() || !below.line[line].surface ||
      !above.line[line].surface)
    return {};
  const std::size_t low = slice * kLineCount + line;
  const glm::dvec3 step = rest.line[low + kLineCount] - rest.line[low];
  const glm::dvec3 across = rest.area[slice] + rest.area[slice + 1];
  if (!(glm::dot(step, across) > kLeastAlong * glm::length(step) * glm::length(across))) return {};
  return step;
}

void measure_folds(const SpineSlices& slices, const SlicePose& rest, const SlicePose& pose,
                   SliceMeasures& out) {
  const std::size_t n = slices.slice.size();
  double whole = 0.0, folded = 0.0, longest = 0.0;
  for (std::size_t k = 0; k < kLineCount; ++k) {
    double run = 0.0;
    int start = -1;
    for (std::size_t r = 0; r + 1 < n; ++r) {
      const std::optional<glm::dvec3> rest_step = forward_step(slices, rest, r, k);
      if (!rest_step) {
        run = 0.0;
        continue;
      }
      const double length = glm::length(*rest_step);
      whole += length;
      const glm::dvec3 along = pose.centre[r + 1] - pose.centre[r];
      const glm::dvec3 normal = pose.area[r] + pose.area[r + 1];
      const std::size_t low = r * kLineCount + k;
      const glm::dvec3 step = pose.line[low + kLineCount] - pose.line[low];
      // Backwards both along the centres and against the slices: one alone may tilt in a bend.
      if (glm::dot(step, along) < 0.0 && glm::dot(step, normal) < 0.0) {
        if (run == 0.0) start = static_cast<int>(r);
        run += length;
        folded += length;
        if (run > longest) {
          longest = run;
          out.fold_slice = start;
        }
      } else {
        run = 0.0;
      }
    }
  }
  out.folded = whole > 0.0 ? folded / whole : kNan;
}

void measure_infeasible(const SpineSlices& slices, const SlicePose& rest, const BendIntent& intent,
                        SliceMeasures& out) {
  for (std::size_t r = 0; r < slices.slice.size(); ++r) {
    const Slice& slice = slices.slice[r];
    if (slice.ring.empty()) continue;
    const glm::dvec3 tangent = glm::normalize(rest.area[r]);
    for (const LinePoint& point : slice.line) {
      const double squeezed = -glm::dot(tangent, glm::cross(intent.bend[r], point.offset));
      if (squeezed > out.infeasible) {
        out.infeasible = squeezed;
        out.infeasible_slice = static_cast<int>(r);
      }
    }
  }
}

constexpr int kLeastWindow = 2;

/// Slices in a row that the spine moves more than limbs do.
int longest_run(const SpineSlices& slices) {
  int run = 0, longest = 0;
  for (const Slice& slice : slices.slice) {
    run = slice.ring.empty() || slice.spine_share < kSpineSlice ? 0 : run + 1;
    longest = std::max(longest, run);
  }
  return longest;
}

/// A second difference of turnings spans three windows between two directions.
int slices_for(int window) { return 3 * window + 2 * kReach + 1; }
int widest_window(int run) { return (run - 2 * kReach - 1) / 3; }

}  // namespace

int slice_window(const SpineSlices& slices, int bones) {
  const int count = static_cast<int>(slices.slice.size());
  const double bone = slices.spacing > 0.0 ? 1.0 / (bones * slices.spacing) : 2.0;
  const int wanted = std::clamp(static_cast<int>(std::lround(bone)), kLeastWindow,
                                std::max(kLeastWindow, count / 6));
  return std::clamp(widest_window(longest_run(slices)), kLeastWindow, wanted);
}

std::string why_no_kinks(const SpineSlices& slices) {
  const int longest = longest_run(slices);
  if (widest_window(longest) >= kLeastWindow) return "";
  return "kinks and twist jumps of the mesh (BB011, BB036) do not apply: " +
         std::to_string(longest) + " slices in a row that the spine moves, " +
         std::to_string(slices_for(kLeastWindow)) + " are needed";
}

std::string why_no_folds(const SpineSlices& slices, const SlicePose& rest) {
  for (std::size_t r = 0; r + 1 < slices.slice.size(); ++r)
    for (std::size_t k = 0; k < kLineCount; ++k)
      if (forward_step(slices, rest, r, k)) return "";
  return "surface folds (BB012) do not apply: no line along the body crosses two slices in a row";
}

SliceMeasures measure_slices(const SpineSlices& slices, const SlicePose& rest,
                             const SlicePose& pose, const BendIntent& intent, int window) {
  assert(window >= 2 && pose.centre.size() == slices.slice.size());
  SliceMeasures out;
  out.planned = slices.slice.size();
  out.measured = slices.measured();

  // Slices that limbs move more than the spine tell nothing of its bend.
  const auto spine_only = [&](std::vector<glm::dvec3> centre) {
    for (std::size_t r = 0; r < centre.size(); ++r)
      if (slices.slice[r].spine_share < kSpineSlice) centre[r] = kNowhere;
    return centre;
  };
  const std::vector<glm::dvec3> posed = directions(spine_only(pose.centre));
  const std::vector<glm::dvec3> at_rest = directions(spine_only(rest.centre));
  out.turning = turnings(posed, window);
  const std::vector<glm::dvec3> asked = turnings(directions(intent.centre), window);
  for (std::size_t r = 0; r < out.turning.size(); ++r) out.turning[r] -= asked[r];
  out.kink_deg =
      second_difference(out.turning, window, [](const glm::dvec3& v) { return glm::length(v); });
  const Worst kink = largest(out.kink_deg);
  out.kink_worst_deg = kink.value;
  out.kink_slice = kink.slice;

  std::vector<double> twist = twists(pose, posed, window);
  const std::vector<double> rest_twist = twists(rest, at_rest, window);
  for (std::size_t r = 0; r < twist.size(); ++r) {
    twist[r] -= rest_twist[r];
    out.twist_deg.push_back(degrees(twist[r]));
  }
  out.twist_jump_deg = second_difference(twist, window, [](double v) { return std::abs(v); });
  const Worst jump = largest(out.twist_jump_deg);
  out.twist_jump_worst_deg = jump.value;
  out.twist_jump_slice = jump.slice;

  out.least_area_ratio = kNan;
  for (std::size_t r = 0; r < out.planned; ++r) {
    const double ratio = glm::length(pose.area[r]) / glm::length(rest.area[r]);
    out.area_ratio.push_back(ratio);
    if (!std::isnan(ratio) && !(ratio >= out.least_area_ratio)) {
      out.least_area_ratio = ratio;
      out.area_slice = static_cast<int>(r);
    }
  }
  measure_folds(slices, rest, pose, out);
  measure_infeasible(slices, rest, intent, out);
  return out;
}

std::vector<double> paired_kink(const SliceMeasures& a, const SliceMeasures& b, int window) {
  assert(a.turning.size() == b.turning.size());
  std::vector<glm::dvec3> difference;
  for (std::size_t r = 0; r < a.turning.size(); ++r)
    difference.push_back(a.turning[r] - b.turning[r]);
  return second_difference(difference, window, [](const glm::dvec3& v) { return glm::length(v); });
}

std::vector<double> paired_twist_jump(const SliceMeasures& a, const SliceMeasures& b, int window) {
  assert(a.twist_deg.size() == b.twist_deg.size());
  std::vector<double> difference;
  for (std::size_t r = 0; r < a.twist_deg.size(); ++r)
    difference.push_back(wrapped(radians_from(a.twist_deg[r] - b.twist_deg[r])));
  return second_difference(difference, window, [](double v) { return std::abs(v); });
}

}  // namespace backbend::validate
