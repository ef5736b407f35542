#include "solver/rig/option_reader.h"

#include <charconv>
#include <cmath>
#include <limits>

#include "solver/rig/nearest_name.h"

namespace backbend::solver {
namespace {

std::string kind_of(const OptionValue& value) {
  struct {
    std::string operator()(bool b) const { return b ? "true" : "false"; }
    std::string operator()(double d) const { return number_text(d); }
    std::string operator()(const std::string& s) const { return "\"" + s + "\""; }
    std::string operator()(const std::vector<double>&) const { return "a list of numbers"; }
    std::string operator()(const std::vector<std::vector<double>>&) const {
      return "a list of lists";
    }
  } text;
  return std::visit(text, value);
}

}  // namespace

std::string number_text(double value) {
  char buffer[32];
  const auto end = std::to_chars(buffer, buffer + sizeof buffer, value).ptr;
  return {buffer, end};
}

void OptionReader::refuse(const std::string& key, const std::string& what) const {
  throw OptionError(key, spec_.system + ": option '" + key + "' " + what);
}

const OptionValue* OptionReader::find(const std::string& key) {
  const auto found = spec_.options.find(key);
  return found == spec_.options.end() ? nullptr : &found->second;
}

bool OptionReader::flag(const std::string& key, bool fallback) {
  ranges_[key] = {OptionRange::Kind::flag};
  bool value = fallback;
  if (const OptionValue* given = find(key)) {
    if (!std::holds_alternative<bool>(*given)) {
      refuse(key, "is " + kind_of(*given) + ", expected true or false");
    }
    value = std::get<bool>(*given);
  }
  record_[key] = value;
  return value;
}

double OptionReader::number(const std::string& key, double fallback, double least, double most) {
  ranges_[key] = {OptionRange::Kind::number, least, most};
  double value = fallback;
  if (const OptionValue* given = find(key)) {
    const std::string range = number_text(least) + " to " + number_text(most);
    if (!std::holds_alternative<double>(*given)) {
      refuse(key, "is " + kind_of(*given) + ", expected a number, " + range);
    }
    value = std::get<double>(*given);
    if (!std::isfinite(value) || value < least || value > most) {
      refuse(key, "is " + number_text(value) + ", expected " + range);
    }
  }
  record_[key] = value;
  return value;
}

int OptionReader::integer(const std::string& key, int fallback, int least, int most) {
  const double value = number(key, fallback, least, most);
  ranges_[key].kind = OptionRange::Kind::integer;
  if (value != std::floor(value)) {
    refuse(key, "is " + number_text(value) + ", expected a whole number");
  }
  return int(value);
}

std::size_t OptionReader::word(const std::string& key,
                               std::initializer_list<std::string_view> allowed) {
  ranges_[key] = {OptionRange::Kind::word, 0.0, 0.0, {allowed.begin(), allowed.end()}};
  std::size_t index = 0;
  if (const OptionValue* given = find(key)) {
    const auto* text = std::get_if<std::string>(given);
    std::string list;
    for (const std::string_view a : allowed)
      list += (list.empty() ? "\"" : ", \"") + std::string(a) + "\"";
    if (!text) refuse(key, "is " + kind_of(*given) + ", expected one of " + list);
    while (index < allowed.size() && allowed.begin()[index] != *text) ++index;
    if (index == allowed.size()) {
      const std::vector<std::string_view> names(allowed);
      const std::string_view near = nearest_name(*text, names);
      refuse(key, "is \"" + *text + "\", expected one of " + list +
                      (near.empty() ? "" : "; did you mean \"" + std::string(near) + "\"?"));
    }
  }
  record_[key] = std::string(allowed.begin()[index]);
  return index;
}

std::vector<double> OptionReader::numbers(const std::string& key, std::vector<double> fallback,
                                          std::size_t count, double least, double most) {
  if (least > -std::numeric_limits<double>::max() && most < std::numeric_limits<double>::max())
    ranges_[key] = {OptionRange::Kind::numbers, least, most};
  std::vector<double> value = std::move(fallback);
  if (const OptionValue* given = find(key)) {
    const auto* list = std::get_if<std::vector<double>>(given);
    if (!list) refuse(key, "is " + kind_of(*given) + ", expected a list of numbers");
    if (count && list->size() != count) {
      refuse(key,
             "has " + std::to_string(list->size()) + " numbers, expected " + std::to_string(count));
    }
    for (const double v : *list) {
      if (!std::isfinite(v) || v < least || v > most) {
        refuse(key, "holds " + number_text(v) + ", expected " + number_text(least) + " to " +
                        number_text(most));
      }
    }
    value = *list;
  }
  record_[key] = value;
  return value;
}

std::vector<std::vector<double>> OptionReader::rows(const std::string& key,
                                                    std::vector<std::vector<double>> fallback) {
  std::vector<std::vector<double>> value = std::move(fallback);
  if (const OptionValue* given = find(key)) {
    const auto* list = std::get_if<std::vector<std::vector<double>>>(given);
    const auto* empty = std::get_if<std::vector<double>>(given);  // [] has no kind of its own
    if (!list && !(empty && empty->empty())) {
      refuse(key, "is " + kind_of(*given) + ", expected a list of lists of numbers");
    }
    value = list ? *list : std::vector<std::vector<double>>{};
    for (const auto& row : value) {
      for (const double v : row) {
        if (!std::isfinite(v)) refuse(key, "holds a number that is not finite");
      }
    }
  }
  record_[key] = value;
  return value;
}

std::vector<std::vector<double>> OptionReader::spans(const std::string& key,
                                                     std::vector<std::vector<double>> fallback,
                                                     double least, double most, double width) {
  const std::size_t count = fallback.size();
  std::string like;
  for (const auto& span : fallback)
    like += (like.empty() ? "[" : ", [") + number_text(span[0]) + ", " + number_text(span[1]) + "]";
  ranges_[key] = {OptionRange::Kind::spans, least, most};
  auto value = rows(key, std::move(fallback));
  for (const auto& span : value) {
    if (value.size() != count || span.size() != 2) {
      refuse(key, "needs " + std::to_string(count) + " spans, from and to, like [" + like + "]");
    }
    if (!(least <= span[0] && span[1] <= most && span[1] - span[0] >= width)) {
      refuse(key, "holds [" + number_text(span[0]) + ", " + number_text(span[1]) +
                      "], expected a span inside " + number_text(least) + ".." + number_text(most) +
                      ", " + number_text(width) + " wide or more");
    }
  }
  return value;
}

std::map<std::string, OptionValue> OptionReader::finish() const {
  for (const auto& [key, value] : spec_.options) {
    if (record_.contains(key)) continue;
    std::vector<std::string> known;
    for (const auto& [name, unused] : record_) known.push_back(name);
    throw OptionError(key,
                      spec_.system + ": unknown option '" + key + "'" + suggestion(key, known));
  }
  return record_;
}

}  // namespace backbend::solver
