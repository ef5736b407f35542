#include "validate/tune/tune_text.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "validate/text/escape.h"
#include "validate/text/joined.h"
#include "validate/text/json_object.h"
#include "validate/verdicts/checks.h"

namespace backbend::validate {
namespace {

using nlohmann::json;

std::string percent(double share) { return number_text(100.0 * share, 0); }

std::string options_text(const TuneChoice& choice) {
  std::vector<std::string> out;
  for (const auto& [key, value] : choice.options) out.push_back(key + " = " + value);
  return joined(out);
}

/// `extension clean to 97 of 60, side to 45 of 45`
std::string channels_text(const TuneChoice& choice) {
  std::vector<std::string> out;
  for (const Headroom& each : choice.channels)
    if (each.measured)
      out.push_back(each.channel + " " + number_text(each.clean_to_deg, 0) + " of " +
                    number_text(each.needs_deg, 0));
  std::string text = "clean to " + joined(out) + " deg";
  if (choice.corners.poses > 0)
    text += "; corners " + number_text(choice.corners.clean_percent(), 0) + " %";
  return text;
}

/// One line of the table.
std::string row_text(const std::string& name, const TuneChoice& choice, const TuneResult& result) {
  const RigGauge& gauge = choice.gauge;
  std::string worst = percent(gauge.least) + " % (" + result.directions[gauge.worst].name;
  if (!gauge.code.empty()) worst += ", " + gauge.code;
  worst += ")";
  return "  " + padded(name, 8) + padded(percent(gauge.headroom) + " %", 10) +
         padded(number_text(gauge.change, 2) + " %", 9) +
         padded(number_text(gauge.change_most, 2) + " %", 9) +
         padded(std::to_string(choice.failures), 10) + worst;
}

json choice_json(const TuneChoice& choice, const TuneResult& result) {
  json options = json::object(), channels = json::object(), directions = json::object();
  for (const auto& [key, value] : choice.options) options[key] = value;
  for (const Headroom& each : choice.channels)
    channels[each.channel] = JsonObject<json>()
                                 .with("clean_to_deg", each.clean_to_deg)
                                 .with("needs_deg", each.needs_deg);
  for (std::size_t d = 0; d < choice.gauge.clean.size(); ++d)
    directions[result.directions[d].name] = choice.gauge.clean[d];
  return JsonObject<json>()
      .with("rig", rig_text(choice.spec))
      .with("options", options)
      .with("headroom", choice.gauge.headroom)
      .with("least", choice.gauge.least)
      .with("least_direction", result.directions[choice.gauge.worst].name)
      .with("least_code", choice.gauge.code)
      .with("directions", directions)
      .with("change_percent", choice.gauge.change)
      .with("change_most_percent", choice.gauge.change_most)
      .with("failures", choice.failures)
      .with("new_failures", choice.made)
      .with("channels", channels)
      .with("corners_clean_percent", choice.corners.clean_percent());
}

}  // namespace

std::string tune_text(const TuneResult& result, bool planned) {
  std::string out;
  const auto line = [&](const std::string& text) { out += visible(text) + "\n"; };
  line("rig " + result.rig + " (mapping " + result.mapping + "), envelope " + result.envelope.name +
       ": " + result.envelope.text());
  for (const OptionAxis& axis : result.varied)
    line("  varied   " + axis.name() + ": " + axis.range_text());
  if (!result.idle.empty()) line("  idle     " + joined(result.idle) + ": change nothing here");
  if (planned) {
    line("  given    headroom " + percent(result.given.gauge.headroom) + " % over " +
         std::to_string(result.directions.size()) + " directions; " + channels_text(result.given));
    line("would measure up to " + std::to_string(result.poses) + " poses of each rig, about " +
         number_text(std::max(0.1, result.minutes), 1) + " min; nothing was searched or written");
    return out;
  }
  line("  measured " + std::to_string(result.evaluations) + " rigs" +
       (result.impossible > 0
            ? ", " + std::to_string(result.impossible) + " combinations are refused"
            : "") +
       "; headroom is the clean share of the way to the envelope's ends, over " +
       std::to_string(result.directions.size()) + " directions");
  out += "\n  choice  headroom  change   at most  failures  least clean direction\n";
  line(row_text("given", result.given, result));
  for (std::size_t i = 0; i < result.choices.size(); ++i)
    line(row_text(std::to_string(i + 1) + (result.chosen == i ? " *" : ""), result.choices[i],
                  result));
  out += "\n";
  line("  given   " + channels_text(result.given));
  for (std::size_t i = 0; i < result.choices.size(); ++i) {
    const TuneChoice& choice = result.choices[i];
    line("  " + std::to_string(i + 1) + "       " + options_text(choice));
    line("          " + channels_text(choice));
    if (!choice.made.empty()) line("          new failures: " + joined(choice.made));
  }
  if (result.choices.empty())
    line("  no rig that was tried has more headroom: the given one stays");
  else if (!result.chosen)
    line("  no choice is within a change of " + number_text(result.change, 2) +
         " % without new failures (--change)");
  else
    line("  * most headroom within a change of " + number_text(result.change, 2) +
         " % of the spine's length (--change)");
  return out;
}

std::string tune_json(const TuneResult& result, bool planned) {
  json varied = json::array(), choices = json::array();
  for (const OptionAxis& axis : result.varied)
    varied.push_back(
        JsonObject<json>().with("option", axis.name()).with("range", axis.range_text()));
  for (const TuneChoice& choice : result.choices) choices.push_back(choice_json(choice, result));
  json out = JsonObject<json>()
                 .with("schema", "backbend.tune/1")
                 .with("character", visible(result.facts.name))
                 .with("rig", result.rig)
                 .with("mapping", result.mapping)
                 .with("envelope", result.envelope.name)
                 .with("varied", varied)
                 .with("idle", result.idle)
                 .with("given", choice_json(result.given, result));
  if (planned) {
    out["minutes"] = result.minutes;
  } else {
    out["evaluations"] = result.evaluations;
    out["refused"] = result.impossible;
    out["change_percent"] = result.change;
    out["choices"] = choices;
    out["chosen"] = result.chosen ? json(*result.chosen + 1) : json();
  }
  return out.dump(2, ' ', false, json::error_handler_t::replace);
}

std::vector<std::string> rig_file_comment(const TuneResult& result) {
  const TuneChoice& choice = result.choices[*result.chosen];
  return {"Tuned from " + result.rig + " for " + result.facts.name + ", envelope " +
              result.envelope.name + ", mapping " + result.mapping + ".",
          "Headroom " + percent(result.given.gauge.headroom) + " % -> " +
              percent(choice.gauge.headroom) + " %, change of the curve " +
              number_text(choice.gauge.change, 2) + " % of the spine, at most " +
              number_text(choice.gauge.change_most, 2) + " %."};
}

}  // namespace backbend::validate
