#include "validate/calibrate/calibrate.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>

namespace backbend::validate {
namespace {

/// At most four digits, no trailing zeros; the same in every locale.
std::string short_number(double value) {
  if (!std::isfinite(value)) return "none";
  std::array<char, 32> text{};
  const auto [end, error] =
      std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::general, 4);
  return error == std::errc() ? std::string(text.data(), end) : "none";
}

nlohmann::json number_or_null(double value) {
  return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json(nullptr);
}

nlohmann::json to_json(const Sensitivity& s) {
  nlohmann::json hits = nlohmann::json::array();
  for (const HitRate& hit : s.hits)
    hits.push_back({{"size", hit.size},
                    {"tried", hit.tried},
                    {"found", hit.found},
                    {"placed", hit.placed},
                    {"roc_area", number_or_null(hit.roc_area)}});
  return {{"detector", s.detector},
          {"code", s.code},
          {"body", s.body},
          {"unit", s.unit},
          {"threshold", number_or_null(s.threshold)},
          {"clean_poses", s.clean},
          {"false_alarms", s.false_alarms},
          {"target", s.target},
          {"smallest_found", number_or_null(s.smallest)},
          {"ok", s.ok()},
          {"sizes", std::move(hits)}};
}

}  // namespace

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
    take(try_mesh_detectors(plan, *body, watch));
    take(try_weight_detectors(plan, *body, watch));
  }
  return report;
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
      "found "
      "at the target | at its place | ROC area |\n|---|---|---|---|---|---|---|---|---|---|\n";
  for (const Sensitivity& s : report.detectors) {
    const auto hit = std::ranges::find(s.hits, s.target, &HitRate::size);
    const bool tried = hit != s.hits.end();
    text += "| " + s.detector + " | " + s.code + " | " + s.body + " | " +
            short_number(s.threshold) + " " + s.unit + " | " + std::to_string(s.clean) + ", " +
            std::to_string(s.false_alarms) + " | " +
            (std::isfinite(s.smallest) ? short_number(s.smallest) + " " + s.unit : "none") + " | " +
            short_number(s.target) + " " + s.unit + " | " +
            (tried ? std::to_string(hit->found) + " of " + std::to_string(hit->tried) : "") +
            " | " + (tried ? std::to_string(hit->placed) : "") + " | " +
            (tried ? short_number(hit->roc_area) : "") + " |\n";
  }
  return text;
}

std::string calibration_json(const CalibrationReport& report) {
  nlohmann::json rows = nlohmann::json::array();
  for (const Sensitivity& s : report.detectors) rows.push_back(to_json(s));
  const nlohmann::json out{{"schema", "backbend.calibration/1"},
                           {"seed", report.plan.seed},
                           {"clean_poses", report.plan.clean_poses},
                           {"fault_poses", report.plan.fault_poses},
                           {"ok", report.ok()},
                           {"detectors", std::move(rows)}};
  return out.dump(2) + "\n";
}

}  // namespace backbend::validate
