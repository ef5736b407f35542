#include "validate/serve/tool_result.h"

#include "validate/text/escape.h"
#include "validate/text/json_object.h"

namespace backbend::validate {
namespace {

using nlohmann::json;

void keep_only(json& object, std::initializer_list<const char*> keys) {
  json kept = json::object();
  for (const char* key : keys)
    if (object.contains(key)) kept[key] = std::move(object[key]);
  object = std::move(kept);
}

void cut(json& list) {
  if (list.size() > kMostListed) list.erase(list.begin() + kMostListed, list.end());
}

void shorten_finding(json& finding) {
  keep_only(finding, {"artist", "between",         "character", "code",    "control_deg", "detail",
                      "frame",  "inside_envelope", "limit",     "mapping", "owner",       "place",
                      "pose",   "cures",           "reproduce", "rig",     "sweep",       "time",
                      "unit",   "value",           "verdict"});
}

void shorten_comparison(json& comparison) { comparison.erase("sweeps"); }

/// report.json as a client gets it.
void shorten_report(json& report) {
  for (json& rig : report["rigs"])
    keep_only(rig,
              {"character", "corners", "headroom", "mapping", "rig", "role", "system", "verdict"});
  json& findings = report["findings"];
  report["findings_in_all"] = findings.size();
  cut(findings);
  for (json& finding : findings) shorten_finding(finding);
  if (report.contains("comparisons"))
    for (json& each : report["comparisons"]) shorten_comparison(each);
  keep_only(report, {"canaries", "characters", "comparisons", "findings", "findings_in_all",
                     "headline", "reasons", "rigs", "suite", "title", "verdict"});
}

bool is_report(const json& object) {
  return object.contains("findings") && object["findings"].is_array() && object.contains("rigs") &&
         object["rigs"].is_array();
}

}  // namespace

ToolResult json_result(std::string_view output, int exit_code) {
  json object = json::parse(output.begin(), output.end(), nullptr, false);
  if (object.is_array())
    object = JsonObject<json>().with("list", std::move(object));
  else if (!object.is_object())
    object = JsonObject<json>().with("text", valid_utf8(output));
  else if (is_report(object))
    shorten_report(object);
  object["exit_code"] = exit_code;
  ToolResult result;
  result.text = object.dump(-1, ' ', false, json::error_handler_t::replace);
  result.structured = std::move(object);
  return result;
}

ToolResult trouble_result(const std::string& line, int exit_code) {
  ToolResult result;
  result.is_error = true;
  result.text = visible(line) + " (exit code " + std::to_string(exit_code) + ")";
  return result;
}

}  // namespace backbend::validate
