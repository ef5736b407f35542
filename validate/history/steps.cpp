#include "validate/history/steps.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace backbend::validate {
namespace {

/// Half the step to be found, in standard deviations: the CUSUM that is best for steps of two.
constexpr double kSlack = 1.0;
/// Where the sum alarms: by simulation 0.9 false alarms in a year of normal noise.
constexpr double kAlarm = 2.7;
/// Scores count for no more than this, so that one outlier (3 - kSlack < kAlarm) is no step.
constexpr double kMostScore = 3.0;
/// Fewer degrees of freedom say nothing about the noise.
constexpr double kLeastFreedom = 3.0;

/// Mean and squared deviations of one level.
struct Level {
  double count = 0, mean = 0, squares = 0;

  void add(double value) {
    count += 1;
    const double from_old = value - mean;
    mean += from_old / count;
    squares += from_old * (value - mean);
  }
};

Level level_of(std::span<const double> values) {
  Level level;
  for (const double value : values)
    if (std::isfinite(value)) level.add(value);
  return level;
}

/// Wallace's normal score of a Student t value.
double normal_score(double t, double freedom) {
  const double size =
      std::sqrt(freedom * std::log1p(t * t / freedom)) * (8 * freedom + 1) / (8 * freedom + 3);
  return std::copysign(size, t);
}

}  // namespace

std::vector<Step> find_steps(std::span<const double> values, double least) {
  assert(least > 0);
  std::vector<Step> steps;
  Level level;                                // of the nights since the last step
  double past_squares = 0, past_freedom = 0;  // of the levels before it
  double up = 0, down = 0;                    // the sums
  std::size_t begin = 0, up_from = 0, down_from = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!std::isfinite(values[i])) continue;
    const double freedom = past_freedom + std::max(0.0, level.count - 1);
    const double noise = freedom > 0 ? std::sqrt((past_squares + level.squares) / freedom) : 0;
    bool stepped = false;
    std::size_t at = i;
    if (freedom < kLeastFreedom) {
      // Too few nights to know the noise, or that there is none.
    } else if (noise < least) {
      stepped = std::abs(values[i] - level.mean) > least;
    } else if (level.count >= 2) {
      const double t = (values[i] - level.mean) / (noise * std::sqrt(1 + 1 / level.count));
      const double score = std::clamp(normal_score(t, freedom), -kMostScore, kMostScore);
      if (up == 0) up_from = i;
      if (down == 0) down_from = i;
      up = std::max(0.0, up + score - kSlack);
      down = std::max(0.0, down - score - kSlack);
      stepped = up > kAlarm || down > kAlarm;
      at = up > kAlarm ? up_from : down_from;
    }
    if (!stepped) {
      level.add(values[i]);
      continue;
    }
    const Level before = level_of(values.subspan(begin, at - begin));
    past_squares += before.squares;
    past_freedom += std::max(0.0, before.count - 1);
    level = level_of(values.subspan(at, i + 1 - at));
    steps.push_back({at, i, before.mean, level.mean});
    begin = at;
    up = down = 0;
  }
  for (std::size_t s = 0; s < steps.size(); ++s) {
    const std::size_t end = s + 1 < steps.size() ? steps[s + 1].at : values.size();
    steps[s].after = level_of(values.subspan(steps[s].at, end - steps[s].at)).mean;
  }
  std::erase_if(steps, [&](const Step& s) { return std::abs(s.after - s.before) <= least; });
  return steps;
}

}  // namespace backbend::validate
