#include "validate/why/why_text.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "validate/model/digest.h"
#include "validate/sweeps/sweep.h"
#include "validate/text/escape.h"
#include "validate/text/joined.h"
#include "validate/text/json_object.h"
#include "validate/text/number_text.h"
#include "validate/verdicts/checks.h"
#include "validate/verdicts/exit_code.h"

namespace backbend::validate {
namespace {

using nlohmann::json;

/// `weights of spine04 on 212 vertices`, `skeleton`, `options depth`.
std::string ingredients_text(const WhyFinding& why) {
  std::string text;
  for (const Ingredient each : members(why.ingredients)) {
    text += (text.empty() ? "" : " together with ") + std::string(name_of(each));
    if (each == Ingredient::weights)
      text += " of " + joined(why.joints) + " on " + std::to_string(why.vertices.size()) +
              (why.vertices.size() == 1 ? " vertex" : " vertices");
    if (each == Ingredient::options) text += " " + joined(why.options);
  }
  return text.empty() ? "not told: mixtures of the two could not be measured" : text;
}

json names_json(IngredientSet set) {
  json out = json::array();
  for (const Ingredient each : members(set)) out.push_back(name_of(each));
  return out;
}

}  // namespace

int WhyResult::exit_code() const {
  return pair && !pair->findings.empty() ? kExitFindings : kExitOk;
}

std::string why_text(const WhyResult& result) {
  std::string out;
  const auto line = [&](const std::string& text) { out += visible(text) + "\n"; };
  for (const std::string& note : result.notes) line(note);
  if (result.first_bad) {
    const FirstBad& first = *result.first_bad;
    line("first bad version: " + result.versions[first.bad] + " (measured " +
         std::to_string(first.steps) + " between the first and the last of " +
         std::to_string(result.versions.size()) + ")");
    if (first.bad - first.good > 1)
      line("  it may be any after " + result.versions[first.good] +
           ": those between cannot be measured");
    for (const std::string& skipped : first.skipped) line("  skipped  " + skipped);
  }
  if (!result.pair) {
    line("no finding of " + result.versions.back() + " is new or worse than in " +
         result.versions.front());
    return out;
  }
  const WhyPair& pair = *result.pair;
  line(pair.after + " against " + pair.before + ", rig " + result.rig + ": " +
       std::to_string(pair.findings.size()) +
       (pair.findings.size() == 1 ? " finding" : " findings") + " new or worse");
  if (pair.changed == 0) line("  nothing that is measured differs");
  for (const auto& [ingredient, text] : pair.differences)
    line("  changed  " + std::string(name_of(ingredient)) + " (" + text + ")");
  if (pair.coverage < 1.0)
    line("  vertices differ: " + number_text(100.0 * pair.coverage, 1) +
         " % correspond by their closest rest point");
  for (const std::string& each : pair.unmeasured) line("  not measured  " + each);
  std::map<std::string, int> told;  // of each check and cause; the worst comes first
  for (const WhyFinding& why : pair.findings) ++told[why.finding.code + ingredients_text(why)];
  for (const WhyFinding& why : pair.findings) {
    const Finding& f = why.finding;
    int& alike = told[f.code + ingredients_text(why)];
    if (alike == 0) continue;
    const int more = std::exchange(alike, 0) - 1;
    const std::string place = place_text(f);
    out += "\n";
    line("  " + f.code + " " + std::string(find_check(f.code)->name) + " " + significant(f.value) +
         " " + f.unit + " (limit " + significant(f.limit) + ", " +
         (why.was ? "was " + significant(*why.was) : "passed before") + "), " + f.pose +
         (place.empty() ? "" : ", " + place));
    line("    made by " + ingredients_text(why));
    if (why.ingredients == bit(Ingredient::program))
      line("    this program measures " +
           (why.without ? significant(*why.without) + " " + f.unit : "a pass"));
    else if (why.ingredients != 0)
      line(std::string("    with the old ") +
           (members(why.ingredients).size() == 1 ? "one" : "ones") + ": " +
           (why.without ? significant(*why.without) + " " + f.unit : "passes"));
    if (more > 0)
      line("    and " + std::to_string(more) +
           " more of this check in other sweeps (--json lists all)");
  }
  return out;
}

std::string why_json(const WhyResult& result) {
  json out = JsonObject<json>()
                 .with("schema", "backbend.why/1")
                 .with("versions", result.versions)
                 .with("rig", result.rig)
                 .with("notes", result.notes);
  if (result.first_bad) {
    out["first_bad"] = JsonObject<json>()
                           .with("version", result.versions[result.first_bad->bad])
                           .with("last_good", result.versions[result.first_bad->good])
                           .with("measurements", result.first_bad->steps)
                           .with("skipped", result.first_bad->skipped);
  }
  json findings = json::array();
  IngredientSet all = 0;
  if (result.pair) {
    const WhyPair& pair = *result.pair;
    out["before"] = pair.before;
    out["after"] = pair.after;
    out["coverage"] = pair.coverage;
    out["changed"] = names_json(pair.changed);
    out["differences"] = json::object();
    for (const auto& [ingredient, text] : pair.differences)
      out["differences"][std::string(name_of(ingredient))] = text;
    out["measured"] = pair.measured;
    out["unmeasured"] = pair.unmeasured;
    for (const WhyFinding& why : pair.findings) {
      all |= why.ingredients;
      const Finding& f = why.finding;
      json each = JsonObject<json>()
                      .with("code", f.code)
                      .with("sweep", f.sweep)
                      .with("pose", f.pose)
                      .with("value", f.value)
                      .with("limit", f.limit)
                      .with("unit", f.unit)
                      .with("place", place_text(f))
                      .with("was", why.was ? json(*why.was) : json())
                      .with("without", why.without ? json(*why.without) : json())
                      .with("ingredients", names_json(why.ingredients));
      if (why.ingredients & bit(Ingredient::weights)) {
        each["joints"] = why.joints;
        each["vertices"] = why.vertices;
      }
      if (why.ingredients & bit(Ingredient::options)) each["options"] = why.options;
      findings.push_back(std::move(each));
    }
  }
  out["findings"] = findings;
  out["ingredients"] = names_json(all);
  return out.dump(1, ' ', false, json::error_handler_t::replace);
}

}  // namespace backbend::validate
