#include "validate/verdicts/limits.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "solver/rig/nearest_name.h"

namespace backbend::validate {
namespace {

[[noreturn]] void unknown_code(std::string_view code) {
  throw LimitError("unknown check '" + std::string(code) + "'; did you mean " +
                   std::string(nearest_code(code)) + "? (see `backbend list checks`)");
}

}  // namespace

std::string_view name_of(LimitLayer layer) {
  switch (layer) {
    case LimitLayer::builtin:
      return "default";
    case LimitLayer::studio:
      return "studio";
    case LimitLayer::show:
      return "show";
    case LimitLayer::character:
      return "character";
  }
  return "";
}

std::string_view nearest_code(std::string_view code) {
  std::string_view best;
  std::size_t best_distance = std::numeric_limits<std::size_t>::max();
  for (const Check& check : all_checks()) {
    const std::size_t distance = solver::edit_distance(code, check.code);
    if (distance < best_distance) {
      best_distance = distance;
      best = check.code;
    }
  }
  return best;
}

LimitSet::LimitSet() {
  for (const Check& check : all_checks())
    limits_[std::string(check.code)].push_back(
        {check.limit, LimitLayer::builtin, "default", "backbend", std::string(check.reason)});
}

void LimitSet::set(std::string_view code, Limit limit) {
  const auto found = limits_.find(code);
  if (found == limits_.end()) unknown_code(code);
  const std::string place = limit.origin.empty() ? "" : limit.origin + ": ";
  if (!std::isfinite(limit.value))
    throw LimitError(place + "limit of " + std::string(code) + " is not a finite number");
  if (limit.reason.empty())
    throw LimitError(place + "limit of " + std::string(code) +
                     " has no reason; add `reason = ...`");
  std::vector<Limit>& history = found->second;
  std::erase_if(history, [&](const Limit& old) { return old.layer == limit.layer; });
  history.push_back(std::move(limit));
  std::ranges::stable_sort(history, {}, &Limit::layer);
}

const std::vector<Limit>& LimitSet::history(std::string_view code) const {
  const auto found = limits_.find(code);
  if (found == limits_.end()) unknown_code(code);
  return found->second;
}

const Limit& LimitSet::of(std::string_view code) const { return history(code).back(); }

Verdict LimitSet::judge(std::string_view code, double measured) const {
  const Check* check = find_check(code);
  if (!check) unknown_code(code);
  return validate::judge(*check, measured, of(code).value);
}

}  // namespace backbend::validate
