#include "validate/tune/option_space.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "solver/rig/nearest_name.h"
#include "validate/text/number_text.h"

namespace backbend::validate {
namespace {

using solver::OptionRange;
using solver::OptionValue;
using solver::RigError;
using Index = std::size_t;

constexpr double kFinest = 1000.0;  // steps of a number in one: what a rigger would type

double in_thousandths(double value) { return std::round(value * kFinest) / kFinest; }

/// How bent an axis' scale is: the exponent k of (e^(k u) - 1) / (e^k - 1) that brings the given
/// value to 1/2; 0 where it stands at an end, or in the middle.
double bend_of(const OptionAxis& axis) {
  const double share = (axis.given - axis.from) / (axis.to - axis.from);
  return share > 0.0 && share < 1.0 ? 2.0 * std::log((1.0 - share) / share) : 0.0;
}

constexpr double kStraight = 1e-9;

bool read_number(const std::string& text, double& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size() && std::isfinite(value);
}

struct Wish {
  std::string key;
  bool has_range = false;
  double from = 0.0, to = 0.0;
};

Wish wish_of(const std::string& text) {
  const Index equals = text.find('=');
  Wish wish;
  wish.key = text.substr(0, equals);
  if (equals == std::string::npos) return wish;
  const std::string range = text.substr(equals + 1);
  const Index colon = range.find(':');
  wish.has_range = true;
  if (colon == std::string::npos || !read_number(range.substr(0, colon), wish.from) ||
      !read_number(range.substr(colon + 1), wish.to))
    throw VaryError("--vary: '" + text + "': expected NAME or NAME=FROM:TO, as in bones=4:20");
  if (!(wish.from < wish.to))
    throw VaryError("--vary: '" + text + "': from " + shortest(wish.from) + " is not below to " +
                    shortest(wish.to));
  return wish;
}

std::vector<double*> numbers_in(OptionValue& value) {
  std::vector<double*> out;
  if (auto* number = std::get_if<double>(&value)) out.push_back(number);
  if (auto* list = std::get_if<std::vector<double>>(&value))
    for (double& each : *list) out.push_back(&each);
  if (auto* rows = std::get_if<std::vector<std::vector<double>>>(&value))
    for (std::vector<double>& row : *rows)
      for (double& each : row) out.push_back(&each);
  return out;
}

}  // namespace

std::string OptionAxis::name() const {
  return place < 0 ? key : key + "[" + std::to_string(place) + "]";
}

std::string OptionAxis::range_text() const {
  if (kind != Kind::choice) return shortest(from) + " to " + shortest(to);
  std::string text;
  for (const OptionValue& choice : choices) {
    const auto* word = std::get_if<std::string>(&choice);
    text += (text.empty() ? "" : " | ") +
            (word ? *word : std::string(std::get<bool>(choice) ? "true" : "false"));
  }
  return text;
}

Index OptionAxis::values() const {
  if (kind == Kind::choice) return choices.size();
  return kind == Kind::whole ? static_cast<Index>(to - from) + 1 : 0;
}

double OptionAxis::at(double unit) const {
  const double u = std::clamp(unit, 0.0, 1.0);
  if (kind == Kind::choice) {
    const auto count = static_cast<double>(choices.size());
    return std::min(count - 1.0, std::floor(u * count));
  }
  const double bend = bend_of(*this);
  const double share = std::abs(bend) < kStraight ? u : std::expm1(bend * u) / std::expm1(bend);
  const double value = from + share * (to - from);
  return std::clamp(kind == Kind::whole ? std::round(value) : in_thousandths(value), from, to);
}

double OptionAxis::unit_of(double value) const {
  if (kind == Kind::choice) return (value + 0.5) / static_cast<double>(choices.size());
  const double bend = bend_of(*this), share = (value - from) / (to - from);
  return std::abs(bend) < kStraight ? share : std::log1p(share * std::expm1(bend)) / bend;
}

OptionSpace::OptionSpace(const solver::SystemSpec& given,
                         const std::map<std::string, OptionValue>& options,
                         const std::map<std::string, OptionRange>& ranges,
                         const std::vector<std::string>& vary)
    : given_(given), options_(options) {
  if (ranges.empty())
    throw RigError("rig '" + given.system + "' has no options with a range: nothing to tune");
  if (vary.empty())
    for (const auto& [key, range] : ranges) add(key, range, range.least, range.most);
  for (const std::string& text : vary) {
    const Wish wish = wish_of(text);
    const auto found = ranges.find(wish.key);
    if (found == ranges.end()) {
      std::vector<std::string> known;
      for (const auto& [key, range] : ranges) known.push_back(key);
      throw VaryError("--vary: " + given.system + " has no option '" + wish.key + "' with a range" +
                      solver::suggestion(wish.key, known));
    }
    const OptionRange& range = found->second;
    const bool is_choice =
        range.kind == OptionRange::Kind::flag || range.kind == OptionRange::Kind::word;
    if (wish.has_range && is_choice)
      throw VaryError("--vary: '" + text + "': the values of '" + wish.key +
                      "' are words; name it without a range");
    if (wish.has_range && (wish.from < range.least || wish.to > range.most))
      throw VaryError("--vary: '" + text + "': expected a range inside " + shortest(range.least) +
                      " to " + shortest(range.most));
    if (range.kind == OptionRange::Kind::integer &&
        (wish.from != std::floor(wish.from) || wish.to != std::floor(wish.to)))
      throw VaryError("--vary: '" + text + "': '" + wish.key + "' takes whole numbers");
    if (std::ranges::any_of(axes_, [&](const OptionAxis& axis) { return axis.key == wish.key; }))
      throw VaryError("--vary: '" + wish.key + "' is named twice");
    add(wish.key, range, wish.has_range ? wish.from : range.least,
        wish.has_range ? wish.to : range.most);
  }
  if (axes_.empty()) throw VaryError("--vary: no number to vary in what was named");
}

void OptionSpace::add(const std::string& key, const OptionRange& range, double least, double most) {
  OptionAxis axis;
  axis.key = key;
  OptionValue& value = options_.at(key);
  if (range.kind == OptionRange::Kind::flag) {
    axis.kind = OptionAxis::Kind::choice;
    axis.choices = {false, true};
    axis.given = std::get<bool>(value) ? 1.0 : 0.0;
    axes_.push_back(std::move(axis));
    return;
  }
  if (range.kind == OptionRange::Kind::word) {
    axis.kind = OptionAxis::Kind::choice;
    for (const std::string& word : range.words) axis.choices.emplace_back(word);
    const auto found = std::ranges::find(range.words, std::get<std::string>(value));
    axis.given = static_cast<double>(found - range.words.begin());
    axes_.push_back(std::move(axis));
    return;
  }
  if (range.kind == OptionRange::Kind::integer) axis.kind = OptionAxis::Kind::whole;
  const std::vector<double*> numbers = numbers_in(value);
  for (Index i = 0; i < numbers.size(); ++i) {
    axis.place = std::holds_alternative<double>(value) ? -1 : static_cast<int>(i);
    axis.given = *numbers[i];
    // A range of the user's that leaves the given value out is widened to it: it is the start.
    axis.from = std::min(least, axis.given);
    axis.to = std::max(most, axis.given);
    if (axis.from < axis.to) axes_.push_back(axis);
  }
}

void OptionSpace::drop(Index axis) {
  axes_.erase(axes_.begin() + static_cast<std::ptrdiff_t>(axis));
}

std::vector<double> OptionSpace::origin() const {
  std::vector<double> out;
  for (const OptionAxis& axis : axes_) out.push_back(axis.unit_of(axis.given));
  return out;
}

solver::SystemSpec OptionSpace::at(std::span<const double> unit) const {
  solver::SystemSpec spec = given_;
  for (Index i = 0; i < axes_.size(); ++i) {
    const OptionAxis& axis = axes_[i];
    const double value = axis.at(unit[i]);
    // Rounding must not move the given rig.
    if (value == axis.at(axis.unit_of(axis.given))) continue;
    if (axis.kind == OptionAxis::Kind::choice) {
      spec.options[axis.key] = axis.choices[static_cast<Index>(value)];
      continue;
    }
    OptionValue& option = spec.options.try_emplace(axis.key, options_.at(axis.key)).first->second;
    *numbers_in(option)[static_cast<Index>(std::max(axis.place, 0))] = value;
  }
  // Spans run from their lower end to their upper.
  for (auto& [key, value] : spec.options)
    if (auto* rows = std::get_if<std::vector<std::vector<double>>>(&value);
        rows && std::ranges::any_of(axes_, [&](const OptionAxis& a) { return a.key == key; }))
      for (std::vector<double>& row : *rows) std::ranges::sort(row);
  return spec;
}

}  // namespace backbend::validate
