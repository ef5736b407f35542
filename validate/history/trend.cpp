#include "validate/history/trend.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "validate/history/steps.h"

namespace backbend::validate {

std::string name_of(const Night& night) {
  return night.label.empty() ? night.date : night.date + " " + night.label;
}

namespace {

/// Changes below this part of a metric's usual size are no news.
constexpr double kLeastPart = 0.001;

double least_change(const std::vector<double>& values) {
  double size = 0, count = 0;
  for (const double v : values)
    if (std::isfinite(v)) size += std::abs(v), ++count;
  return std::max(count > 0 ? kLeastPart * size / count : 0.0, 1e-9);
}

void add_steps(Trend& trend, const std::vector<const Night*>& nights) {
  const double least = least_change(trend.value);
  for (const Step& step : find_steps(trend.value, least)) {
    TrendStep out;
    out.night = static_cast<int>(step.at);
    out.before = step.before;
    out.after = step.after;
    out.worse = (step.after > step.before) == trend.more_is_worse;
    out.version = name_of(*nights[step.at]);
    if (step.at > 0) out.last_before = name_of(*nights[step.at - 1]);
    trend.steps.push_back(out);
  }
  // A step for the worse has recovered where a later level is back within a tenth of the step.
  for (std::size_t i = 0; i < trend.steps.size(); ++i) {
    TrendStep& bad = trend.steps[i];
    if (!bad.worse) continue;
    for (std::size_t k = i + 1; k < trend.steps.size() && bad.recovered.empty(); ++k) {
      const double left = trend.steps[k].after - bad.before;
      const double lost = bad.after - bad.before;
      if (left / lost < 0.1) bad.recovered = trend.steps[k].version;
    }
  }
}

/// 0: a step for the worse that still stands; 1: any step; 2: steady.
int rank(const Trend& trend) {
  if (std::any_of(trend.steps.begin(), trend.steps.end(),
                  [](const TrendStep& s) { return s.worse && s.recovered.empty(); }))
    return 0;
  return trend.steps.empty() ? 2 : 1;
}

}  // namespace

TrendTable trends_of(const std::vector<Night>& history, const std::string& suite,
                     std::size_t nights) {
  std::vector<const Night*> shown;
  for (const Night& night : history)
    if (night.suite == suite) shown.push_back(&night);
  if (shown.size() > nights)
    shown.erase(shown.begin(), shown.end() - static_cast<std::ptrdiff_t>(nights));
  std::vector<Trend> trends;
  std::map<std::tuple<std::string, std::string, std::string, std::string>, std::size_t> place;
  for (std::size_t n = 0; n < shown.size(); ++n) {
    for (const NightValue& v : shown[n]->values) {
      const auto [at, is_new] =
          place.emplace(std::tuple(v.character, v.rig, v.mapping, v.metric), trends.size());
      if (is_new) {
        Trend trend;
        trend.character = v.character;
        trend.rig = v.rig;
        trend.mapping = v.mapping;
        trend.metric = v.metric;
        trend.value.assign(shown.size(), std::numeric_limits<double>::quiet_NaN());
        trends.push_back(std::move(trend));
      }
      Trend& trend = trends[at->second];
      trend.unit = v.unit;
      trend.more_is_worse = v.more_is_worse;
      trend.value[n] = v.value;
    }
  }
  for (Trend& trend : trends) add_steps(trend, shown);
  std::stable_sort(trends.begin(), trends.end(),
                   [](const Trend& a, const Trend& b) { return rank(a) < rank(b); });
  TrendTable table;
  for (const Night* night : shown) table.nights.push_back(name_of(*night));
  table.trends = std::move(trends);
  return table;
}

std::optional<Onset> first_bad(const std::vector<Night>& history, const std::string& character,
                               const std::string& code) {
  std::optional<Onset> last;
  const Night* good = nullptr;
  bool open = false;
  for (const Night& night : history) {
    // A night that did not look at the character says nothing about it.
    if (!night.version.contains(character)) continue;
    const auto failure = std::find_if(
        night.failures.begin(), night.failures.end(),
        [&](const NightFailure& f) { return f.character == character && f.code == code; });
    if (failure == night.failures.end()) {
      if (open) last->recovered = &night;
      open = false;
      good = &night;
    } else if (open) {
      ++last->bad_nights;
    } else {
      last = Onset{&night, good, nullptr, 1, *failure};
      open = true;
    }
  }
  return last;
}

}  // namespace backbend::validate
