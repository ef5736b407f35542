#include "validate/repair/repair_text.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "skin/character/printable.h"
#include "validate/text/json_object.h"
#include "validate/verdicts/checks.h"
#include "validate/verdicts/names.h"

namespace backbend::validate {
namespace {

using nlohmann::ordered_json;

constexpr std::size_t kMostLines = 5;  // of what is not cured

/// What remains on the mesh inside the envelope, whoever it is booked to, one of each check: what a
/// rigger must know that weights cannot do.
std::vector<const Finding*> not_cured(const WeightRepair& repair) {
  std::vector<const Finding*> out;
  const auto add = [&](const Finding& finding) {
    const bool known =
        std::ranges::any_of(out, [&](const Finding* other) { return other->code == finding.code; });
    if (!known && out.size() < kMostLines) out.push_back(&finding);
  };
  for (const Finding& finding : repair.after) add(finding);
  for (const Finding& finding : repair.others)
    if (find_check(finding.code)->subject == Subject::mesh && finding.inside_envelope) add(finding);
  for (const Finding& finding : repair.others)
    if (finding.code == "BB068") add(finding);
  return out;
}

/// What would cure it, as far as it was measured.
std::string cure_of(const Finding& finding) {
  const Check& check = *find_check(finding.code);
  if (finding.code == "BB068") return "the bind pose is at fault, not the weights";
  const auto passes = [&](const char* what) {
    const auto found = finding.geometry.find(what);
    return found != finding.geometry.end() &&
           judge(check, found->second, finding.limit) == Verdict::pass;
  };
  const auto value = [&](const char* what) { return number_text(finding.geometry.at(what), 3); };
  if (passes("dual_quaternion"))
    return "dual quaternion skinning would give " + value("dual_quaternion");
  if (passes("proxy_weights"))
    return "automatic test weights give " + value("proxy_weights") + ", so other weights can";
  if (finding.owner == Owner::skeleton)
    return "clean weights show it, too: it needs more spine joints, or a corrective shape";
  if (finding.owner == Owner::pose) return "the body is too thick for this bend";
  if (check.subject == Subject::mesh)
    return "clean weights and dual quaternions show it, too: it needs a corrective shape or "
           "another joint";
  return "no change that was tried removes it";
}

std::string padded(std::string text, std::size_t width) {
  if (text.size() < width) text.append(width - text.size(), ' ');
  return text;
}

std::string right(const std::string& text, std::size_t width) {
  return text.size() < width ? std::string(width - text.size(), ' ') + text : text;
}

double touched_percent(const WeightRepair& repair) {
  return repair.touched.empty() ? 0.0
                                : 100.0 * static_cast<double>(repair.touched_count) /
                                      static_cast<double>(repair.touched.size());
}

}  // namespace

std::string repair_text(const WeightRepair& repair) {
  std::string out = "Repairing the WEIGHTS of " + skin::printable(repair.character.name) + ": " +
                    skin::count_text(repair.touched.size()) + " vertices, envelope " +
                    repair.envelope + ", " + skin::count_text(repair.poses) +
                    " poses under our rig 'even'\n";
  if (repair.checks.empty()) {
    out += "  nothing to repair: no failure that is the weights'\n";
  } else {
    out += "  check                         failures      worst, times its limit\n";
    for (const RepairedCheck& each : repair.checks)
      out += "  " + padded(each.code + " " + each.name, 28) +
             right(std::to_string(each.before), 4) + " -> " +
             padded(std::to_string(each.after), 8) + right(number_text(each.worst_before, 2), 7) +
             " -> " + number_text(each.worst_after, 2) + "\n";
  }
  for (const RepairStep& step : repair.steps)
    out += (step.taken ? "  done      " : "  not done  ") + step.what +
           (step.why_not.empty() ? "" : ": " + step.why_not) +
           (step.costs.empty() ? "" : "; advisory: " + step.costs) + "\n";
  if (repair.touched_count > 0)
    out += "  touched   " + skin::count_text(repair.touched_count) + " of " +
           skin::count_text(repair.touched.size()) + " vertices (" +
           number_text(touched_percent(repair), 2) + " %); largest change " +
           number_text(100.0 * repair.largest_change, 1) + " % of the weight of vertex " +
           std::to_string(repair.largest_vertex) + "\n";
  for (const Finding* finding : not_cured(repair))
    out += "  not cured " + finding->code + " " + std::string(find_check(finding->code)->name) +
           ", " + (finding->sweep.empty() ? skin::printable(finding->joint) : finding->pose) +
           ": " + number_text(finding->value, 3) + " (limit " + number_text(finding->limit, 2) +
           ", " + std::string(name_of(finding->owner)) + "); " + cure_of(*finding) + "\n";
  return out;
}

std::string repair_json(const WeightRepair& repair) {
  ordered_json checks = ordered_json::array(), steps = ordered_json::array(),
               rest = ordered_json::array();
  const auto number = [](double value) {
    return std::isfinite(value) ? ordered_json(value) : ordered_json(nullptr);
  };
  for (const RepairedCheck& each : repair.checks)
    checks.push_back(JsonObject<ordered_json>()
                         .with("code", each.code)
                         .with("name", each.name)
                         .with("failures_before", each.before)
                         .with("failures_after", each.after)
                         .with("worst_before", number(each.worst_before))
                         .with("worst_after", number(each.worst_after)));
  for (const RepairStep& step : repair.steps)
    steps.push_back(JsonObject<ordered_json>()
                        .with("change", step.what)
                        .with("done", step.taken)
                        .with("why_not", step.why_not)
                        .with("costs", step.costs));
  for (const Finding* finding : not_cured(repair))
    rest.push_back(JsonObject<ordered_json>()
                       .with("code", finding->code)
                       .with("pose", finding->pose)
                       .with("joint", finding->joint)
                       .with("value", number(finding->value))
                       .with("limit", number(finding->limit))
                       .with("unit", finding->unit)
                       .with("owner", name_of(finding->owner))
                       .with("cure", cure_of(*finding))
                       .with("detail", finding->detail));
  const ordered_json root = JsonObject<ordered_json>()
                                .with("schema", "backbend.repair/1")
                                .with("character", repair.character.name)
                                .with("envelope", repair.envelope)
                                .with("poses", repair.poses)
                                .with("checks", checks)
                                .with("steps", steps)
                                .with("vertices", repair.touched.size())
                                .with("touched", repair.touched_count)
                                .with("largest_change", repair.largest_change)
                                .with("largest_vertex", repair.largest_vertex)
                                .with("not_cured", rest);
  return root.dump(2, ' ', false, ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace backbend::validate
