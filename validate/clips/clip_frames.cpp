#include "validate/clips/clip_frames.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "validate/metrics/math/median.h"
#include "validate/sweeps/sweep.h"

namespace backbend::validate {
namespace {

using Index = std::size_t;

}  // namespace

double control_range(const skin::Clip& clip, const skin::ClipSweep& range, Index control) {
  double low = std::numeric_limits<double>::quiet_NaN(), high = low;
  for (Index f = range.first; f < range.first + range.count; ++f) {
    low = std::fmin(low, control_value(clip, f, control));
    high = std::fmax(high, control_value(clip, f, control));
  }
  return high - low > 0.0 ? high - low : 0.0;
}

std::optional<Index> leading_control(const skin::Clip& clip, const skin::ClipSweep& range) {
  std::optional<Index> best;
  double widest = 0.0;
  for (Index c = 0; c < clip.control.size(); ++c) {
    const double moves = control_range(clip, range, c);
    if (moves > widest) {
      widest = moves;
      best = c;
    }
  }
  return best;
}

std::vector<double> control_travel(const skin::Clip& clip, const skin::ClipSweep& range) {
  constexpr double kLeastStep = 0.01, kWidest = 3.0;  // degrees; of the median step
  std::vector<double> travel(range.count, 0.0), step;
  for (Index i = 1; i < range.count; ++i) {
    double square = 0.0;
    for (Index c = 0; c < clip.control.size(); ++c) {
      const Index f = range.first + i;
      const double way = control_value(clip, f, c) - control_value(clip, f - 1, c);
      if (!(way == 0.0) && PoseDegrees().find(clip.control[c]) == nullptr) return {};
      square += way * way;
    }
    if (!(square >= kLeastStep * kLeastStep)) return {};
    step.push_back(std::sqrt(square));
    travel[i] = travel[i - 1] + step.back();
  }
  if (step.empty()) return {};
  const double widest = *std::ranges::max_element(step);
  if (widest > kWidest * upper_median(step)) return {};
  return travel;
}

}  // namespace backbend::validate
