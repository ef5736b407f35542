#include "validate/calibrate/sensitivity.h"

#include <algorithm>
#include <cmath>

#include "validate/metrics/math/nan.h"

namespace backbend::validate {
namespace {

constexpr double kHitRate = 0.99;

}  // namespace

Agreement& Agreement::operator+=(const Agreement& other) {
  both += other.both;
  geometry_only += other.geometry_only;
  picture_only += other.picture_only;
  neither += other.neither;
  return *this;
}

Agreement Sensitivity::agreement() const {
  Agreement out = clean_agreement;
  for (const HitRate& hit : hits) out += hit.agreement;
  return out;
}

double threshold_from(const std::vector<double>& clean, double floor) {
  if (clean.empty()) return kNan;
  double largest = 0.0;
  for (double value : clean) {
    if (!std::isfinite(value)) return kNan;
    largest = std::max(largest, value);
  }
  return std::max(1.25 * largest, floor);
}

double roc_area(const std::vector<double>& clean, const std::vector<double>& faulted) {
  if (clean.empty() || faulted.empty()) return kNan;
  const auto ranked = [](std::vector<double> values) {
    for (double& v : values)
      if (std::isnan(v)) v = -std::numeric_limits<double>::infinity();
    std::ranges::sort(values);
    return values;
  };
  const std::vector<double> low = ranked(clean), high = ranked(faulted);
  double wins = 0.0;
  for (double value : high) {
    const auto below = std::ranges::lower_bound(low, value) - low.begin();
    const auto not_above = std::ranges::upper_bound(low, value) - low.begin();
    wins += 0.5 * static_cast<double>(below + not_above);
  }
  return wins / (static_cast<double>(low.size()) * static_cast<double>(high.size()));
}

Sensitivity judge_detector(std::string detector, std::string code, std::string body,
                           std::string unit, double target, double threshold,
                           const std::vector<double>& clean,
                           const std::vector<FaultTrial>& trials) {
  Sensitivity out;
  out.detector = std::move(detector);
  out.code = std::move(code);
  out.body = std::move(body);
  out.unit = std::move(unit);
  out.threshold_unit = out.unit;
  out.target = target;
  out.threshold = threshold;
  out.clean = clean.size();
  // A clean pose that could not be measured is an alarm too: it must not pass unseen.
  out.false_alarms = static_cast<std::size_t>(
      std::ranges::count_if(clean, [&](double value) { return !(value <= threshold); }));
  for (const FaultTrial& trial : trials) {
    HitRate hit{trial.size, trial.value.size(), 0, trial.placed, roc_area(clean, trial.value), {}};
    hit.found = static_cast<std::size_t>(
        std::ranges::count_if(trial.value, [&](double value) { return value > threshold; }));
    out.hits.push_back(hit);
  }
  std::ranges::stable_sort(out.hits, {}, &HitRate::size);
  // The smallest from which on every larger size was found as well.
  for (auto hit = out.hits.rbegin(); hit != out.hits.rend() && hit->rate() >= kHitRate; ++hit)
    out.smallest = hit->size;
  return out;
}

}  // namespace backbend::validate
