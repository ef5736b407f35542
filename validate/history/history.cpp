#include "validate/history/history.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>
#include <tuple>

#include "validate/files/descriptor.h"
#include "validate/files/hash.h"
#include "validate/files/output_folder.h"
#include "validate/history/history_index.h"
#include "validate/measure/measure.h"
#include "validate/model/report_json.h"
#include "validate/text/escape.h"
#include "validate/text/json_object.h"
#include "validate/verdicts/checks.h"
#include "validate/verdicts/names.h"
#include "validate/verdicts/waivers.h"

namespace backbend::validate {
namespace {

using nlohmann::json;

bool more_is_worse(const std::string& name) {
  const Metric* metric = metric_named(name);
  return metric == nullptr || metric->check().sense == Sense::at_most;
}

std::string unit_of(const RigResult& rig, const std::string& metric) {
  for (const SweepSeries& sweep : rig.sweeps)
    if (const auto unit = sweep.metric_unit.find(metric); unit != sweep.metric_unit.end())
      return unit->second;
  return "";
}

json number(double value) { return std::isfinite(value) ? json(value) : json(nullptr); }

double number_of(const json& value) {
  return value.is_null() ? std::numeric_limits<double>::quiet_NaN() : value.get<double>();
}

/// Values of the first version of the lines: one object each.
void read_objects(const json& values, Night& night) {
  for (const json& v : values) {
    night.values.push_back({v.at("character").get<std::string>(), v.at("rig").get<std::string>(),
                            v.at("mapping").get<std::string>(), v.at("metric").get<std::string>(),
                            v.at("unit").get<std::string>(), v.at("more_is_worse").get<bool>(),
                            number_of(v.at("value"))});
  }
}

/// `[character, rig, mapping, [metric, value, metric, value ...]]`, metrics by their place in
/// `metrics`.
void read_rows(const json& metrics, const json& rows, Night& night) {
  for (const json& row : rows) {
    const json& list = row.at(3);
    if (list.size() % 2 != 0) throw std::invalid_argument("'values': a metric without a value");
    for (std::size_t k = 0; k < list.size(); k += 2) {
      const json& metric = metrics.at(list.at(k).get<std::size_t>());
      night.values.push_back({row.at(0).get<std::string>(), row.at(1).get<std::string>(),
                              row.at(2).get<std::string>(), metric.at(0).get<std::string>(),
                              metric.at(1).get<std::string>(), metric.at(2).get<bool>(),
                              number_of(list.at(k + 1))});
    }
  }
}

Night night_from(const json& line) {
  Night night;
  const std::string schema = line.at("schema").get<std::string>();
  if (schema != kNightSchemaName && schema != kFirstNightSchemaName)
    throw std::invalid_argument("expected schema '" + std::string(kNightSchemaName) + "'");
  night.date = line.at("date").get<std::string>();
  if (!is_day(night.date))
    throw std::invalid_argument("'date': invalid day; expected one like 2026-11-22");
  night.label = line.at("label").get<std::string>();
  night.suite = line.at("suite").get<std::string>();
  night.report = line.at("report").get<std::string>();
  night.results = line.value("results", "");
  const auto verdict = verdict_from_word(line.at("verdict").get<std::string>());
  if (!verdict) throw std::invalid_argument("unknown verdict");
  night.verdict = *verdict;
  night.version = line.at("version").get<std::map<std::string, std::string>>();
  if (schema == kFirstNightSchemaName)
    read_objects(line.at("values"), night);
  else
    read_rows(line.at("metrics"), line.at("values"), night);
  for (const json& f : line.at("failures")) {
    night.failures.push_back({f.at("character").get<std::string>(), f.at("rig").get<std::string>(),
                              f.at("mapping").get<std::string>(), f.at("code").get<std::string>(),
                              f.at("pose").get<std::string>(), number_of(f.at("value"))});
  }
  return night;
}

}  // namespace

Night night_of(const Report& report, const std::string& date, const std::string& label,
               const std::optional<std::string>& report_hash) {
  Night night;
  night.date = date;
  night.label = label;
  night.suite = report.suite;
  night.report = report_hash ? *report_hash : content_hash(report_json(report));
  night.verdict = report.verdict;
  for (const CharacterFacts& facts : report.characters) night.version[facts.name] = facts.hash;
  std::map<std::string, Role> role;
  for (const RigResult& rig : report.rigs) {
    role[rig.rig] = rig.role;
    if (rig.role == Role::canary) continue;
    for (const Headroom& h : rig.headroom) {
      const double value = h.measured ? h.headroom_deg() : std::numeric_limits<double>::quiet_NaN();
      night.values.push_back(
          {rig.character, rig.rig, rig.mapping, "headroom " + h.channel, "deg", false, value});
    }
    for (const auto& [metric, value] : rig.summary) {
      night.values.push_back({rig.character, rig.rig, rig.mapping, metric, unit_of(rig, metric),
                              more_is_worse(metric), value});
    }
  }
  for (const Finding& f : report.findings) {
    const auto found = role.find(f.rig);
    if (f.verdict != Verdict::fail || (found != role.end() && found->second != Role::proposed))
      continue;
    const bool known =
        std::any_of(night.failures.begin(), night.failures.end(), [&](const NightFailure& other) {
          return std::tie(other.character, other.rig, other.mapping, other.code) ==
                 std::tie(f.character, f.rig, f.mapping, f.code);
        });
    // Findings come worst first.
    if (!known) night.failures.push_back({f.character, f.rig, f.mapping, f.code, f.pose, f.value});
  }
  return night;
}

std::string news_of(const std::vector<Night>& nights) {
  if (nights.empty()) return {};
  const Night& tonight = nights.back();
  const auto before = std::find_if(nights.rbegin() + 1, nights.rend(), [&](const Night& night) {
    return night.suite == tonight.suite;
  });
  if (before == nights.rend()) return {};
  const auto failing = [](const Night& night) {
    std::set<std::tuple<std::string, std::string, std::string, std::string>> keys;
    for (const NightFailure& each : night.failures)
      keys.emplace(each.character, each.rig, each.mapping, each.code);
    return keys;
  };
  const auto then = failing(*before), now = failing(tonight);
  if (then.empty() && now.empty()) return {};
  const auto missing_from = [](const auto& keys, const auto& others) {
    return std::count_if(keys.begin(), keys.end(),
                         [&](const auto& key) { return !others.contains(key); });
  };
  const std::string since =
      before->date + (before->label.empty() ? "" : " (" + before->label + ")");
  std::string text = now.empty() ? std::string("nothing fails any more")
                                 : std::to_string(missing_from(now, then)) + " of " +
                                       std::to_string(now.size()) +
                                       (now.size() == 1 ? " failing check is new since "
                                                        : " failing checks are new since ") +
                                       since;
  if (const auto gone = missing_from(then, now); gone > 0)
    text += ", " + std::to_string(gone) + (gone == 1 ? " has" : " have") +
            (now.empty() ? " gone since " + since : " gone");
  return text;
}

std::string night_json(const Night& night) {
  json metrics = json::array(), values = json::array(), failures = json::array();
  std::map<json, std::size_t> place;  // of each metric
  const NightValue* before = nullptr;
  for (const NightValue& v : night.values) {
    const json metric = {valid_utf8(v.metric), valid_utf8(v.unit), v.more_is_worse};
    const auto [found, is_new] = place.emplace(metric, metrics.size());
    if (is_new) metrics.push_back(metric);
    if (before == nullptr || std::tie(before->character, before->rig, before->mapping) !=
                                 std::tie(v.character, v.rig, v.mapping))
      values.push_back(
          {valid_utf8(v.character), valid_utf8(v.rig), valid_utf8(v.mapping), json::array()});
    values.back().back().push_back(found->second);
    values.back().back().push_back(number(v.value));
    before = &v;
  }
  for (const NightFailure& f : night.failures) {
    failures.push_back(JsonObject<json>()
                           .with("character", valid_utf8(f.character))
                           .with("rig", valid_utf8(f.rig))
                           .with("mapping", valid_utf8(f.mapping))
                           .with("code", valid_utf8(f.code))
                           .with("pose", valid_utf8(f.pose))
                           .with("value", number(f.value)));
  }
  json version = json::object();
  for (const auto& [character, hash] : night.version)
    version[valid_utf8(character)] = valid_utf8(hash);
  json line = JsonObject<json>()
                  .with("schema", kNightSchemaName)
                  .with("date", night.date)
                  .with("label", valid_utf8(night.label))
                  .with("suite", valid_utf8(night.suite))
                  .with("report", night.report)
                  .with("verdict", verdict_word(night.verdict))
                  .with("version", version)
                  .with("metrics", metrics)
                  .with("values", values)
                  .with("failures", failures);
  if (!night.results.empty()) line["results"] = night.results;
  return line.dump();
}

std::vector<Night> parse_history(std::string_view text, std::string_view name) {
  std::vector<Night> nights;
  std::size_t number = 0;
  while (!text.empty()) {
    ++number;
    const std::string place = visible(name) + ":" + std::to_string(number) + ": ";
    const std::size_t end = text.find('\n');
    if (end == std::string_view::npos) {
      throw HistoryError(place + "the last line was cut short; remove it, and add its run again " +
                         "with backbend history --add");
    }
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(end + 1);
    try {
      nights.push_back(night_from(json::parse(line.begin(), line.end())));
    } catch (const json::exception& error) {
      throw HistoryError(place + "damaged: " + visible(error.what()));
    } catch (const std::invalid_argument& error) {
      throw HistoryError(place + "damaged: " + error.what());
    }
  }
  return nights;
}

bool append_night(const std::filesystem::path& file, const Night& night) {
  const auto refuse = [&](const char* what) {
    const int error = errno;
    throw WriteError(file.string() + ": " + what + ": " + std::strerror(error), error);
  };
  if (file.has_parent_path()) OutputFolder(file.parent_path()).prepare();
  const Descriptor out(::open(file.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0666));
  if (out.number() < 0) refuse("cannot be opened to add a night");
  // Held until the descriptor closes: two runs that end together add two whole lines.
  if (::flock(out.number(), LOCK_EX) != 0) refuse("cannot be locked");
  const std::vector<Night> last = HistoryIndex(file).last_nights(night.suite, 1, {});
  if (!last.empty() && last[0].report == night.report && last[0].date == night.date) return false;
  const off_t size = ::lseek(out.number(), 0, SEEK_END);
  const std::string line = night_json(night) + '\n';
  const ssize_t written = ::write(out.number(), line.data(), line.size());
  if (written != static_cast<ssize_t>(line.size()) || ::fsync(out.number()) != 0) {
    const int error = written >= 0 && written < static_cast<ssize_t>(line.size()) ? ENOSPC : errno;
    // What was there stays; half a line would make the next reading fail.
    if (::ftruncate(out.number(), size) != 0) errno = error;
    errno = error;
    refuse("a night cannot be added");
  }
  return true;
}

}  // namespace backbend::validate
