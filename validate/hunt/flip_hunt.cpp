#include "validate/hunt/flip_hunt.h"

#include <algorithm>
#include <cmath>
#include <glm/trigonometric.hpp>
#include <limits>

#include "validate/measure/measure.h"
#include "validate/metrics/chain/rig_probe.h"
#include "validate/metrics/math/rotation.h"
#include "validate/sweeps/named_pose.h"

namespace backbend::validate {
namespace {

using Index = std::size_t;
using Point = std::vector<double>;

constexpr double kHalfPath_deg = 1.0;
constexpr double kFirstStep = 0.02, kLeastStep = 1e-9;  // of an axis
constexpr double kSnap_deg = 1e-5;                      // nearer to 0 is 0
constexpr Index kMostPaths = 12, kMostFollowed = 4;
constexpr double kAxisStep_deg = 5.0;
constexpr double kApart = 0.005;  // of an axis: two paths at one place
constexpr double kFirstShift_deg = 0.05;

}  // namespace

FlipHunt::FlipHunt(const solver::SpineSystem& system, solver::Mapping mapping,
                   const ControlBox& box, double gain_limit, Index evaluations)
    : system_(system), mapping_(mapping), box_(box), gain_limit_(gain_limit), left_(evaluations) {}

void FlipHunt::pose_at(const Point& at, solver::SpinePose& pose) const {
  system_.solve_into(controls_at(system_, box_.pose_at(at), mapping_), solver::Detail::joints,
                     pose);
}

/// Degrees of turn per degree of control, the fastest joint along the fastest axis, between two
/// poses `reach` (of the axis) to either side.
double FlipHunt::steepness(const Point& at, double reach) {
  double most = 0.0;
  solver::SpinePose before, after;
  for (Index a = 0; a < at.size(); ++a) {
    Point p = at, q = at;
    p[a] = std::max(at[a] - reach, 0.0);
    q[a] = std::min(at[a] + reach, 1.0);
    pose_at(p, before);
    pose_at(q, after);
    spent_ += 2;
    const double degrees = (q[a] - p[a]) * box_.axes[a].width();
    for (Index j = 0; j < before.turn.size(); ++j)
      most = std::max(
          most, glm::degrees(glm::length(turn_between(before.turn[j], after.turn[j]))) / degrees);
  }
  return std::isfinite(most) ? most : 0.0;
}

double FlipHunt::least_margin(const Point& at) {
  solver::SpinePose pose;
  pose_at(at, pose);
  ++spent_;
  double least = std::numeric_limits<double>::infinity();
  for (const double margin : pose.flip_margin) least = std::min(least, margin);
  return least;
}

/// Uphill by a compass search along the axes, to where the chain turns fastest, or the flip margin
/// is least.
Point FlipHunt::sharpened(Point at, Index budget) {
  const bool has_margin = !system_.rest().flip_margin.empty();
  const Index end = spent_ + std::min(budget, left_);
  const Index before = spent_;
  double step = kFirstStep;
  const auto height = [&](const Point& p) {
    return has_margin ? -least_margin(p) : steepness(p, 0.25 * step);
  };
  const Index each = has_margin ? 1 : 2 * at.size(), poll = (2 * at.size() + 1) * each;
  if (spent_ + each + poll > end) return at;
  double value = height(at);
  while (step > kLeastStep && spent_ + poll <= end) {
    Point best = at;
    double best_value = value;
    for (Index a = 0; a < at.size(); ++a)
      for (const double direction : {-1.0, 1.0}) {
        Point p = at;
        p[a] = std::clamp(p[a] + direction * step, 0.0, 1.0);
        if (p[a] == at[a]) continue;
        if (const double here = height(p); here > best_value) {
          best_value = here;
          best = std::move(p);
        }
      }
    if (best == at) {
      step *= 0.3;
      if (!has_margin) value = height(at);  // seen from nearer it may be steeper
    } else {
      at = best;
      value = best_value;
    }
  }
  left_ -= std::min(left_, spent_ - before);
  return at;
}

FlipReport FlipHunt::flips_on(const PoseDegrees& from, const PoseDegrees& to) {
  // As measured of a suite's named pose: search_flips().
  const Sweep sweep = named_pose("hunt", from, to);
  const auto path = [&](double t) {
    return controls_at(system_, sweep.pose_at(sweep.to_deg * t), mapping_);
  };
  const int intervals = static_cast<int>(sweep.pose_count()) - 1;
  prepare_search(system_, path, intervals);
  FlipReport flips =
      find_flips(probe(system_, path), flip_settings(system_, intervals, sweep.to_deg));
  confirmations_ += flips.samples;
  return flips;
}

std::optional<FlipPath> FlipHunt::path_through(const Point& at, const Point& direction_deg) {
  double largest = 0.0;
  for (const double d : direction_deg) largest = std::max(largest, std::abs(d));
  if (!(largest > 0.0)) return std::nullopt;
  Point before = at, after = at;
  for (Index a = 0; a < at.size(); ++a) {
    const double reach = kHalfPath_deg * direction_deg[a] / largest / box_.axes[a].width();
    before[a] = std::clamp(at[a] - reach, 0.0, 1.0);
    after[a] = std::clamp(at[a] + reach, 0.0, 1.0);
  }
  const auto rounded = [&](const Point& point) {
    PoseDegrees pose = box_.pose_at(point);
    for (const std::string_view channel : kChannels)
      if (double& value = *pose.find(channel); std::abs(value) < kSnap_deg) value = 0.0;
    return in_file_digits(pose);
  };
  FlipPath path{rounded(before), rounded(after), at, 0.0, 0.0};
  if (pose_words(path.from) == pose_words(path.to)) return std::nullopt;
  const FlipReport flips = flips_on(path.from, path.to);
  for (const Jump& jump : flips.jumps) path.jump_deg = std::max(path.jump_deg, jump.size_deg());
  for (const double gain : flips.gain)
    if (std::isfinite(gain)) path.gain = std::max(path.gain, gain);
  return path;
}

std::vector<FlipPath> FlipHunt::paths(const std::vector<Suspect>& suspects,
                                      const std::optional<Point>& least_margin) {
  std::vector<FlipPath> out;
  const auto add = [&](const std::optional<FlipPath>& path) {
    if (!path || (path->jump_deg == 0.0 && path->gain <= gain_limit_)) return;
    for (FlipPath& other : out) {
      if (distance(other.at, path->at) >= kApart) continue;
      if (std::pair(path->jump_deg, path->gain) > std::pair(other.jump_deg, other.gain))
        other = *path;
      return;
    }
    out.push_back(*path);
  };
  const auto middle = [](const Suspect& suspect) {
    Point at = suspect.before;
    for (Index a = 0; a < at.size(); ++a) at[a] = 0.5 * (at[a] + suspect.after[a]);
    return at;
  };
  const auto direction = [&](const Suspect& suspect) {
    Point out_deg = suspect.after;
    for (Index a = 0; a < out_deg.size(); ++a)
      out_deg[a] = (suspect.after[a] - suspect.before[a]) * box_.axes[a].width();
    return out_deg;
  };
  std::vector<Point> followed;
  const auto follow = [&](const Point& at) {
    if (followed.size() < kMostFollowed &&
        std::ranges::none_of(followed, [&](const Point& f) { return distance(f, at) < 0.1; }))
      followed.push_back(at);
  };
  for (const FlipPath& path : on_axes()) add(path);
  if (least_margin) follow(*least_margin);
  for (const Suspect& suspect : suspects) {
    bool jumps = suspect.jumps;
    if (jumps && out.size() < kMostPaths) {
      const std::optional<FlipPath> path = path_through(middle(suspect), direction(suspect));
      add(path);
      jumps = path && path->jump_deg > 0.0;
    }
    if (!jumps) follow(middle(suspect));
  }
  for (Index i = 0; i < followed.size(); ++i) {
    const Point at = sharpened(followed[i], left_ / (followed.size() - i));
    for (Index a = 0; a < at.size(); ++a) {
      Point along(at.size(), 0.0);
      along[a] = 1.0;
      add(path_through(at, along));
    }
  }
  const Point rest = box_.point_of({});
  std::ranges::stable_sort(out, [&](const FlipPath& a, const FlipPath& b) {
    if ((a.jump_deg > 0.0) != (b.jump_deg > 0.0)) return a.jump_deg > 0.0;
    return distance(a.at, rest) < distance(b.at, rest);
  });
  return out;
}

/// Across the jumps that lie on the axes through rest, where people look first.
std::vector<FlipPath> FlipHunt::on_axes() {
  std::vector<FlipPath> out;
  const Point rest = box_.point_of({});
  for (Index a = 0; a < rest.size(); ++a) {
    const double degrees = box_.axes[a].width();
    const auto intervals = static_cast<int>(std::ceil(degrees / kAxisStep_deg));
    if (left_ < static_cast<Index>(5 * intervals)) break;
    const auto point = [&](double t) {
      Point at = rest;
      at[a] = std::min(t, 1.0);
      return at;
    };
    const auto path = [&](double t) {
      return controls_at(system_, box_.pose_at(point(t)), mapping_);
    };
    prepare_search(system_, path, intervals);
    FlipSettings settings = flip_settings(system_, intervals, degrees);
    settings.budget = left_ - 1;
    const FlipReport flips = find_flips(probe(system_, path), settings);
    spent_ += flips.samples;
    left_ -= std::min(left_, flips.samples);
    Point along(rest.size(), 0.0);
    along[a] = 1.0;
    for (const Jump& jump : flips.jumps)
      if (out.size() < kMostPaths)
        if (auto found = path_through(point(jump.t), along)) out.push_back(std::move(*found));
  }
  return out;
}

void FlipHunt::measure_width(const FlipPath& path, bool jump,
                             std::map<std::string, double>& width_deg) {
  const Point start = box_.point_of(path.from), end = box_.point_of(path.to);
  Index along = 0;
  const auto run = [&](Index a) { return std::abs(end[a] - start[a]) * box_.axes[a].width(); };
  for (Index a = 1; a < start.size(); ++a)
    if (run(a) > run(along)) along = a;
  for (Index a = 0; a < start.size(); ++a) {
    if (a == along) continue;
    double width = 0.0;
    for (const double side : {-1.0, 1.0}) {
      // The place wanders along the path as this is moved: the path follows it.
      double shift = kFirstShift_deg, reached = 0.0, drift = 0.0, slope = 0.0;
      while (true) {
        Point p = start, q = end;
        const double axis_shift = side * shift / box_.axes[a].width();
        const double follow = drift + slope * (shift - reached);
        if (p[a] + axis_shift < -1e-9 || p[a] + axis_shift > 1.0 + 1e-9 ||
            q[a] + axis_shift < -1e-9 || q[a] + axis_shift > 1.0 + 1e-9)
          break;
        for (Index b = 0; b < p.size(); ++b) {
          const double step = follow * (end[b] - start[b]);
          p[b] = std::clamp(p[b] + step + (a == b ? axis_shift : 0.0), 0.0, 1.0);
          q[b] = std::clamp(q[b] + step + (a == b ? axis_shift : 0.0), 0.0, 1.0);
        }
        const PoseDegrees from = in_file_digits(box_.pose_at(p)),
                          to = in_file_digits(box_.pose_at(q));
        if (pose_words(from) == pose_words(to)) break;
        const FlipReport flips = flips_on(from, to);
        double t = -1.0;
        if (jump && !flips.jumps.empty()) t = flips.jumps.front().t;
        if (!jump)
          for (const SteepSpot& spot : flips.steep) t = spot.t;
        if (t < 0.0) break;
        // In lengths of the path: where the place is now against where it was.
        const double place = follow + t - 0.5;
        slope = (place - drift) / (shift - reached);
        drift = place;
        reached = shift;
        shift *= 2.0;
      }
      width += reached;
    }
    width_deg[box_.axes[a].name] = width;
  }
}

}  // namespace backbend::validate
