#include "validate/history/baseline.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <tuple>

#include "validate/files/hash.h"
#include "validate/model/digest.h"
#include "validate/model/report_json.h"
#include "validate/text/escape.h"
#include "validate/text/json_object.h"
#include "validate/text/number_text.h"
#include "validate/verdicts/checks.h"
#include "validate/verdicts/waivers.h"

namespace backbend::validate {
namespace {

using nlohmann::json;

constexpr std::string_view kBaselineSchema = "backbend.baseline/1";
constexpr std::string_view kApprovalsSchema = "backbend.approvals/1";
/// The same bits come back every night; between builds the last digits may differ.
constexpr double kSameValue = 1e-6;

bool is_flip_inside(const Finding& f) { return f.code == "BB001" && f.inside_envelope; }

bool low_is_bad(const std::string& code) {
  const Check* check = find_check(code);
  return check != nullptr && check->sense == Sense::at_least;
}

/// The joint that tells two findings apart. A place on the mesh is next to one joint tonight and,
/// half a slice further, next to another tomorrow: it is told by its sweep alone.
std::string case_joint(const Finding& f) { return f.slice < 0 && f.vertex < 0 ? f.joint : ""; }

/// Drift of the arms had no joint before: what was approved without one holds for each.
bool same_joint(const Approval& a, const Finding& f) {
  const bool arms = f.code == "BB020" || f.code == "BB021";
  return a.joint == case_joint(f) || (arms && a.joint.empty());
}

bool same_case(const Approval& a, const Finding& f) {
  return std::tie(a.code, a.character, a.rig, a.mapping, a.sweep) ==
             std::tie(f.code, f.character, f.rig, f.mapping, f.sweep) &&
         same_joint(a, f);
}

bool is_worse(const Finding& f, double approved) {
  const double slack = kSameValue * std::max(std::abs(approved), std::abs(f.value));
  return low_is_bad(f.code) ? !(f.value >= approved - slack) : !(f.value <= approved + slack);
}

std::string until_text(const Approval& a) { return a.until.empty() ? "" : " until " + a.until; }

void apply_to(Finding& finding, const Baseline& baseline, std::string_view today) {
  const Approval *holds = nullptr, *expired = nullptr, *outgrown = nullptr;
  for (const Approval& a : baseline.approvals) {
    if (!same_case(a, finding)) continue;
    if (is_worse(finding, a.value))
      outgrown = &a;
    else if (!a.until.empty() && today > a.until)
      expired = &a;
    else
      holds = &a;
  }
  const std::string so_far = finding.detail.empty() ? "" : finding.detail + "; ";
  if (holds != nullptr) {
    finding.verdict = Verdict::waived;
    finding.detail = so_far + "approved at " + significant(holds->value) + until_text(*holds) +
                     " by " + holds->author + ": " + holds->reason;
  } else if (expired != nullptr) {
    finding.detail = so_far + "its approval expired on " + expired->until;
  } else if (outgrown != nullptr) {
    finding.detail = so_far + "worse than the approved " + significant(outgrown->value);
  }
}

json parse_json(std::string_view text, std::string_view name, std::string_view schema) {
  try {
    json document = json::parse(text.begin(), text.end());
    if (document.at("schema").get<std::string>() != schema)
      throw BaselineError(visible(name) + ": expected schema '" + std::string(schema) + "'");
    return document;
  } catch (const json::exception& error) {
    throw BaselineError(visible(name) + ": damaged: " + visible(error.what()));
  }
}

json line_of(const Approval& a) {
  json pictures = json::object();
  for (const auto& [kind, hash] : a.pictures) pictures[kind] = hash;
  return JsonObject<json>()
      .with("code", valid_utf8(a.code))
      .with("character", valid_utf8(a.character))
      .with("rig", valid_utf8(a.rig))
      .with("mapping", valid_utf8(a.mapping))
      .with("sweep", valid_utf8(a.sweep))
      .with("joint", valid_utf8(a.joint))
      .with("value", a.value)
      .with("unit", valid_utf8(a.unit))
      .with("pictures", pictures)
      .with("author", valid_utf8(a.author))
      .with("reason", valid_utf8(a.reason))
      .with("date", a.date)
      .with("until", a.until)
      .with("report", a.report);
}

Approval approval_from(const json& line) {
  const auto text = [&](const char* key) { return line.at(key).get<std::string>(); };
  Approval a;
  a.code = text("code");
  a.character = text("character");
  a.rig = text("rig");
  a.mapping = text("mapping");
  a.sweep = text("sweep");
  a.joint = text("joint");
  a.value = line.at("value").get<double>();
  a.unit = text("unit");
  a.pictures = line.at("pictures").get<std::map<std::string, std::string>>();
  a.author = text("author");
  a.reason = text("reason");
  a.date = text("date");
  a.until = text("until");
  a.report = text("report");
  return a;
}

bool same_approval(const Approval& a, const Approval& b) {
  return std::tie(a.code, a.character, a.rig, a.mapping, a.sweep, a.joint, a.value, a.pictures) ==
         std::tie(b.code, b.character, b.rig, b.mapping, b.sweep, b.joint, b.value, b.pictures);
}

}  // namespace

std::string baseline_json(const Baseline& baseline) {
  std::string text = "{\"schema\": \"" + std::string(kBaselineSchema) +
                     "\", \"suite\": " + json(valid_utf8(baseline.suite)).dump() +
                     ", \"approvals\": [";
  for (std::size_t i = 0; i < baseline.approvals.size(); ++i)
    text += (i > 0 ? ",\n " : "\n ") + line_of(baseline.approvals[i]).dump();
  return text + "\n]}\n";
}

Baseline parse_baseline(std::string_view text, std::string_view name) {
  const json document = parse_json(text, name, kBaselineSchema);
  Baseline baseline;
  std::size_t number = 0;
  try {
    baseline.suite = document.at("suite").get<std::string>();
    for (const json& line : document.at("approvals")) {
      baseline.approvals.push_back(approval_from(line));
      const Approval& a = baseline.approvals.back();
      if (!is_day(a.date) || !(a.until.empty() || is_day(a.until)))
        throw BaselineError(visible(name) + ": approval " + std::to_string(number) +
                            ": invalid date; expected a day like 2026-11-22");
      ++number;
    }
  } catch (const json::exception& error) {
    throw BaselineError(visible(name) + ": approval " + std::to_string(number) +
                        ": damaged: " + visible(error.what()));
  }
  return baseline;
}

void apply_baseline(std::span<Finding> findings, const std::function<Role(const Finding&)>& role_of,
                    const Baseline& baseline, std::string_view today) {
  for (Finding& finding : findings)
    if (finding.verdict == Verdict::fail && role_of(finding) == Role::proposed &&
        !is_flip_inside(finding))
      apply_to(finding, baseline, today);
}

Approvals parse_approvals(std::string_view text, std::string_view name) {
  const json document = parse_json(text, name, kApprovalsSchema);
  Approvals approvals;
  try {
    approvals.report = document.at("report").get<std::string>();
    approvals.suite = document.at("suite").get<std::string>();
    approvals.author = document.at("author").get<std::string>();
    approvals.reason = document.at("reason").get<std::string>();
    approvals.until = document.at("until").get<std::string>();
    for (const json& one : document.at("cases")) {
      if (!one.at("finding").is_number_unsigned())
        throw BaselineError(visible(name) + ": 'finding' is not an index");
      approvals.cases.push_back(
          {one.at("finding").get<std::size_t>(), one.at("hash").get<std::string>()});
    }
  } catch (const json::exception& error) {
    throw BaselineError(visible(name) + ": damaged: " + visible(error.what()));
  }
  return approvals;
}

Approvals approvals_of_all(const Report& report) {
  const Digest digest(report);
  Approvals approvals;
  approvals.report = content_hash(report_json(report));
  approvals.suite = report.suite;
  for (std::size_t i = 0; i < report.findings.size(); ++i) {
    const Finding& f = report.findings[i];
    if (f.verdict == Verdict::fail && digest.role_of(f) == Role::proposed && !is_flip_inside(f))
      approvals.cases.push_back({i, finding_hash(f)});
  }
  return approvals;
}

Baseline approve(const Baseline& before, const Report& report, const Approvals& approvals,
                 std::string_view today,
                 const std::function<std::string(const std::string&)>& picture_hash) {
  const auto refuse = [](const std::string& why) { throw BaselineError(why); };
  if (approvals.report != content_hash(report_json(report)))
    refuse("stale: these approvals are of another report; open the run's own page again");
  if (approvals.suite != report.suite)
    refuse("these approvals are for suite '" + visible(approvals.suite) + "', the run is of '" +
           visible(report.suite) + "'");
  if (!before.approvals.empty() && before.suite != report.suite)
    refuse("the baseline is for suite '" + visible(before.suite) + "', the run is of '" +
           visible(report.suite) + "'");
  if (approvals.author.empty()) refuse("an approval needs an author");
  if (approvals.reason.empty()) refuse("an approval needs a reason");
  if (!approvals.until.empty() && !is_day(approvals.until))
    refuse("'" + visible(approvals.until) + "': invalid day; expected one like 2026-12-15");
  if (!approvals.until.empty() && approvals.until < today)
    refuse("the approval would end on " + approvals.until + ", before today");
  const Digest digest(report);
  Baseline after = before;
  after.suite = report.suite;
  for (const Approvals::Case& one : approvals.cases) {
    const std::string place = "case of finding " + std::to_string(one.finding) + ": ";
    if (one.finding >= report.findings.size()) refuse(place + "the report has no such finding");
    const Finding& f = report.findings[one.finding];
    if (finding_hash(f) != one.hash) refuse(place + "wrong hash: this is not what was looked at");
    if (f.verdict != Verdict::fail || digest.role_of(f) != Role::proposed ||
        !std::isfinite(f.value))
      refuse(place + "only failures of a proposed rig can be approved");
    if (is_flip_inside(f)) refuse(place + "a flip inside the envelope cannot be approved");
    Approval a{f.code,           f.character,      f.rig,
               f.mapping,        f.sweep,          case_joint(f),
               f.value,          f.unit,           {},
               approvals.author, approvals.reason, std::string(today),
               approvals.until,  approvals.report};
    for (const auto& [kind, path] :
         {std::pair("before", f.pictures.before), std::pair("after", f.pictures.after),
          std::pair("heat", f.pictures.heat), std::pair("other", f.pictures.other)}) {
      if (path.empty()) continue;
      a.pictures[kind] = picture_hash(path);
      if (a.pictures[kind].empty())
        refuse(place + "its picture " + visible(path) + " is not in the run's folder");
    }
    const auto same = std::find_if(after.approvals.begin(), after.approvals.end(),
                                   [&](const Approval& other) { return same_approval(other, a); });
    if (same != after.approvals.end())
      *same = a;
    else
      after.approvals.push_back(a);
  }
  return after;
}

}  // namespace backbend::validate
