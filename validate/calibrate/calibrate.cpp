#include "validate/calibrate/calibrate.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "validate/files/output_folder.h"
#include "validate/tasks/seconds_of.h"
#include "validate/text/escape.h"
#include "validate/text/json_object.h"
#include "validate/verdicts/waivers.h"

namespace backbend::validate {
namespace {

constexpr const char* kSchema = "backbend.calibration/1";

/// At most four digits, no trailing zeros; the same in every locale.
std::string short_number(double value) {
  if (!std::isfinite(value)) return "none";
  std::array<char, 32> text{};
  const auto [end, error] =
      std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::general, 4);
  return error == std::errc() ? std::string(text.data(), end) : "none";
}

std::string alike(const Agreement& a) {
  return std::to_string(a.alike()) + " of " + std::to_string(a.cases());
}

nlohmann::json number_or_null(double value) {
  return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json(nullptr);
}

nlohmann::json to_json(const Agreement& a) {
  return JsonObject<nlohmann::json>()
      .with("both", a.both)
      .with("geometry_only", a.geometry_only)
      .with("picture_only", a.picture_only)
      .with("neither", a.neither);
}

nlohmann::json to_json(const Sensitivity& s) {
  nlohmann::json hits = nlohmann::json::array();
  for (const HitRate& hit : s.hits) {
    hits.push_back(JsonObject<nlohmann::json>()
                       .with("size", hit.size)
                       .with("tried", hit.tried)
                       .with("found", hit.found)
                       .with("placed", hit.placed)
                       .with("roc_area", number_or_null(hit.roc_area)));
    if (hit.agreement.cases() > 0) hits.back()["agreement"] = to_json(hit.agreement);
  }
  nlohmann::json out = JsonObject<nlohmann::json>()
                           .with("detector", s.detector)
                           .with("code", s.code)
                           .with("body", s.body)
                           .with("unit", s.unit)
                           .with("threshold", number_or_null(s.threshold))
                           .with("threshold_unit", s.threshold_unit)
                           .with("clean_poses", s.clean)
                           .with("false_alarms", s.false_alarms)
                           .with("target", s.target)
                           .with("smallest_found", number_or_null(s.smallest))
                           .with("ok", s.ok())
                           .with("sizes", std::move(hits));
  if (s.clean_agreement.cases() > 0) out["clean_agreement"] = to_json(s.clean_agreement);
  return out;
}

}  // namespace

Agreement CalibrationReport::agreement() const {
  Agreement out;
  for (const Sensitivity& s : detectors) out += s.agreement();
  return out;
}

bool CalibrationReport::ok() const {
  return !detectors.empty() &&
         std::ranges::all_of(detectors, [](const Sensitivity& s) { return s.ok(); });
}

CalibrationReport calibrate(const CalibrationPlan& plan,
                            std::span<const CalibrationBody* const> bodies,
                            const CalibrationWatch& watch) {
  CalibrationReport report;
  report.plan = plan;
  const auto take = [&](std::vector<Sensitivity> rows) {
    for (Sensitivity& row : rows) report.detectors.push_back(std::move(row));
  };
  report.detectors.push_back(try_flip_detector(plan, watch));
  for (int bones : plan.chain_bones) take(try_chain_detectors(plan, bones, watch));
  for (const CalibrationBody* body : bodies) {
    const std::vector<Sensitivity> measured = try_mesh_detectors(plan, *body, watch);
    take(measured);
    take(try_pictures(plan, *body, measured, watch));
    take(try_weight_detectors(plan, *body, watch));
  }
  return report;
}

double estimate_minutes(const CalibrationPlan& plan, std::span<const CalibrationBody* const> bodies,
                        const std::function<void()>& poll) {
  constexpr std::size_t kFew = 8;
  const auto seconds_with = [&](std::size_t poses) {
    CalibrationPlan small = plan;
    small.clean_poses = poses;
    small.fault_poses = std::max<std::size_t>(1, plan.fault_poses * poses / plan.clean_poses);
    CalibrationWatch watch;
    watch.on_step = poll;
    return seconds_of([&] { calibrate(small, bodies, watch); });
  };
  const double few = seconds_with(kFew), twice = seconds_with(2 * kFew);
  const double a_pose = std::max(0.0, twice - few) / kFew;
  const double more = static_cast<double>(plan.clean_poses) - 2.0 * kFew;
  return std::max(0.0, twice + a_pose * more) / 60.0;
}

std::vector<std::string> detector_lines(const CalibrationReport& report) {
  std::vector<std::string> lines;
  for (const Sensitivity& s : report.detectors) {
    std::string line = s.detector + "  " + s.body + ": ";
    if (std::isfinite(s.smallest)) {
      line += "from " + short_number(s.smallest) + " " + s.unit;
    } else {
      const HitRate* largest = s.hits.empty() ? nullptr : &s.hits.back();
      line += "not for sure";
      if (largest)
        line += " (" + short_number(100.0 * largest->rate()) + " % at " +
                short_number(largest->size) + " " + s.unit + ")";
    }
    line += ", " + std::to_string(s.false_alarms) + " of " + std::to_string(s.clean) +
            " clean poses flagged";
    lines.push_back(std::move(line));
  }
  return lines;
}

std::string calibration_table(const CalibrationReport& report) {
  std::string text =
      "| detector | check | tried on | alarm over | clean, flagged | smallest found | target | "
      "found at the target | at its place | ROC area | pictures and geometry alike: clean, at the "
      "target |\n|---|---|---|---|---|---|---|---|---|---|---|\n";
  for (const Sensitivity& s : report.detectors) {
    const auto hit = std::ranges::find(s.hits, s.target, &HitRate::size);
    const bool tried = hit != s.hits.end(), pictures = s.clean_agreement.cases() > 0;
    text += "| " + s.detector + " | " + s.code + " | " + s.body + " | " +
            short_number(s.threshold) + " " + s.threshold_unit + " | " + std::to_string(s.clean) +
            ", " + std::to_string(s.false_alarms) + " | " +
            (std::isfinite(s.smallest) ? short_number(s.smallest) + " " + s.unit : "none") + " | " +
            short_number(s.target) + " " + s.unit + " | " +
            (tried ? std::to_string(hit->found) + " of " + std::to_string(hit->tried) : "") +
            " | " + (tried && !pictures ? std::to_string(hit->placed) : "") + " | " +
            (tried ? short_number(hit->roc_area) : "") + " | " +
            (tried && pictures ? alike(s.clean_agreement) + ", " + alike(hit->agreement) : "") +
            " |\n";
  }
  return text;
}

std::string calibration_json(const CalibrationReport& report) {
  nlohmann::json rows = nlohmann::json::array();
  for (const Sensitivity& s : report.detectors) rows.push_back(to_json(s));
  const nlohmann::json out = JsonObject<nlohmann::json>()
                                 .with("schema", kSchema)
                                 .with("date", report.date)
                                 .with("seed", report.plan.seed)
                                 .with("clean_poses", report.plan.clean_poses)
                                 .with("fault_poses", report.plan.fault_poses)
                                 .with("ok", report.ok())
                                 .with("detectors", std::move(rows));
  return out.dump(2) + "\n";
}

std::string last_calibration(const std::filesystem::path& file, const std::string& today) {
  if (!std::filesystem::exists(file))
    return "no whole calibration beside the history yet: 'backbend calibrate' makes one";
  std::size_t clean = 0, alarms = 0;
  std::string missed, date;
  std::set<std::string> bodies;
  try {
    const nlohmann::json stored = nlohmann::json::parse(read_text(file));
    if (stored.at("schema") != kSchema) throw CalibrationError("it is of another schema");
    date = stored.at("date").get<std::string>();
    for (const nlohmann::json& row : stored.at("detectors")) {
      const std::string body = row.at("body").get<std::string>();
      bodies.insert(body);
      clean += row.at("clean_poses").get<std::size_t>();
      alarms += row.at("false_alarms").get<std::size_t>();
      if (!row.at("ok").get<bool>())
        missed +=
            (missed.empty() ? "" : ", ") + row.at("detector").get<std::string>() + " on " + body;
    }
    if (!is_day(date)) throw CalibrationError("'date': invalid day; expected one like 2026-11-22");
  } catch (const std::exception& error) {
    throw CalibrationError(visible(file.string()) +
                           ": not a calibration: " + visible(error.what()));
  }
  const int days = days_between(date, today);
  // Another machine's clock may be ahead: of a day to come the date says enough.
  const std::string age =
      days < 0 ? "" : ", " + std::to_string(days) + (days == 1 ? " day ago" : " days ago");
  return "whole calibration of " + date + age + (days > 7 ? " (repeat it every week)" : "") +
         ", on " + std::to_string(bodies.size()) + " bodies and chains: " +
         (missed.empty() ? "each detector found its target"
                         : "NOT at their target: " + visible(missed)) +
         ", " + std::to_string(alarms) + " of " + std::to_string(clean) + " clean poses flagged";
}

}  // namespace backbend::validate
