#include "solver/systems/even_limits.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "solver/math/rotation.h"

namespace backbend::solver {
namespace {

/// share[j] = min(t weight[j], room[j]) with the t that makes them add up to `total`, or room[j]
/// everywhere that a weight reaches if they cannot. Returns what is missing. All >= 0.
double pour(double total, const std::vector<double>& weight, const std::vector<double>& room,
            std::vector<double>& share) {
  const std::size_t count = weight.size();
  share.assign(count, 0.0);
  std::vector<std::size_t> order;
  for (std::size_t j = 0; j < count; ++j) {
    if (weight[j] > 0.0) order.push_back(j);
  }
  // Joints fill up in the order of room over weight.
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    const double fa = room[a] * weight[b], fb = room[b] * weight[a];
    return fa != fb ? fa < fb : a < b;
  });
  double open = 0.0, left = total;
  for (const std::size_t j : order) open += weight[j];
  for (std::size_t i = 0; i < order.size(); ++i) {
    const std::size_t j = order[i];
    if (left * weight[j] <= room[j] * open) {
      // From here on every joint has room for its part.
      for (; i < order.size(); ++i) share[order[i]] = left * (weight[order[i]] / open);
      return 0.0;
    }
    share[j] = room[j];
    left -= room[j];
    open -= weight[j];
  }
  return std::max(left, 0.0);
}

constexpr const char* kDirection[3][2] = {
    {"twist right", "twist left"}, {"side bend left", "side bend right"}, {"extension", "flexion"}};

}  // namespace

EvenLimits::EvenLimits(const EvenWeights& weights, std::vector<double> ends,
                       std::vector<RangeOfMotion> range_deg)
    : end_(std::move(ends)) {
  assert(end_.size() == range_deg.size());
  double from = 0.0;
  for (std::size_t j = 0; j < end_.size(); ++j) {
    std::array<double, kUpperChannels> before{}, step{};
    for (int ch = 0; ch < kUpperChannels; ++ch) {
      before[ch] = weights.of(ch)(from);
      step[ch] = weights.of(ch)(end_[j]) - before[ch];
    }
    from_.push_back(before);
    step_.push_back(step);
    const RangeOfMotion& r = range_deg[j];
    low_.push_back({-radians(r.axial), -radians(r.side), -radians(r.extension)});
    high_.push_back({radians(r.axial), radians(r.side), radians(r.flexion)});
    from = end_[j];
  }
}

EvenLimits::Result EvenLimits::apply(const UpperChannels& channel) const {
  const std::size_t count = end_.size();
  Result result;
  result.share.resize(count);
  std::vector<double> weight(count), room(count), poured;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> taken(count, 0.0);
    for (const int ch : {3 + axis, axis}) {
      const double total = std::abs(channel[ch]);
      const double sign = channel[ch] < 0.0 ? -1.0 : 1.0;
      bool inside = true;
      for (std::size_t j = 0; j < count; ++j) {
        weight[j] = step_[j][ch];
        room[j] = std::max(0.0, sign > 0.0 ? high_[j][axis] - taken[j] : taken[j] - low_[j][axis]);
        inside = inside && total * weight[j] <= room[j];
      }
      if (inside) {
        for (std::size_t j = 0; j < count; ++j) {
          result.share[j].scale[ch] = channel[ch];
          taken[j] += channel[ch] * weight[j];
        }
        continue;
      }
      result.lost[ch] = sign * pour(total, weight, room, poured);
      double done = 0.0;
      for (std::size_t j = 0; j < count; ++j) {
        const double own = sign * poured[j];
        const double scale = weight[j] > 0.0 ? own / weight[j] : 0.0;
        result.share[j].scale[ch] = scale;
        result.share[j].base[ch] = done - scale * from_[j][ch];
        done += own;
        taken[j] += own;
      }
    }
    for (const int side : {0, 1}) {
      std::string joints;
      for (std::size_t j = 0; j < count; ++j) {
        const double limit = side ? high_[j][axis] : -low_[j][axis];
        const double used = side ? taken[j] : -taken[j];
        if (!(limit > 0.0) || used < limit * (1.0 - 1e-9)) continue;
        joints += (joints.empty() ? " " : ", ") + std::to_string(j + 1);
        ++result.joints_at_limit;
      }
      if (!joints.empty()) {
        result.flags.push_back(std::string(kDirection[axis][side]) + " is at its limit at joint" +
                               joints);
      }
    }
  }
  return result;
}

}  // namespace backbend::solver
