#include "validate/report/junit.h"

#include <algorithm>
#include <string_view>

#include "validate/model/digest.h"
#include "validate/text/escape.h"
#include "validate/verdicts/names.h"

namespace backbend::validate {
namespace {

enum class CaseOutcome { passed, failed, error, skipped };

struct Case {
  std::string class_name, name;
  CaseOutcome outcome = CaseOutcome::passed;
  std::string message, text;
};

std::string attribute(std::string_view name, std::string_view value) {
  return ' ' + std::string(name) + "=\"" + markup_text(value) + '"';
}

std::string lines_of(const std::string& text) {
  std::string out;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    out += markup_text(std::string_view(text).substr(at, end - at)) + '\n';
    at = end + 1;
  }
  return out;
}

std::string xml(const Case& c) {
  std::string out = "    <testcase" + attribute("classname", c.class_name) +
                    attribute("name", c.name) + attribute("time", "0");
  if (c.outcome == CaseOutcome::passed) return out + "/>\n";
  const std::string tag = c.outcome == CaseOutcome::failed  ? "failure"
                          : c.outcome == CaseOutcome::error ? "error"
                                                            : "skipped";
  out += ">\n      <" + tag + attribute("message", c.message);
  if (c.outcome != CaseOutcome::skipped) out += attribute("type", "backbend");
  out += '>';
  out += lines_of(c.text) + "</" + tag + ">\n    </testcase>\n";
  return out;
}

std::string xml(const std::string& suite, const std::vector<Case>& cases) {
  const auto count = [&](CaseOutcome wanted) {
    return std::to_string(std::count_if(cases.begin(), cases.end(),
                                        [&](const Case& c) { return c.outcome == wanted; }));
  };
  std::string out =
      "  <testsuite" + attribute("name", suite) + attribute("tests", std::to_string(cases.size())) +
      attribute("failures", count(CaseOutcome::failed)) +
      attribute("errors", count(CaseOutcome::error)) +
      attribute("skipped", count(CaseOutcome::skipped)) + attribute("time", "0") + ">\n";
  for (const Case& c : cases) out += xml(c);
  return out + "  </testsuite>\n";
}

std::string line_of(const Finding& f) {
  std::string line = std::string(verdict_word(f.verdict)) + ": " + visible(f.pose);
  if (const std::string place = place_text(f); !place.empty()) line += ", " + visible(place);
  line += ": " + visible(value_text(f));
  if (f.owner != Owner::none) line.append(", ").append(owner_word(f.owner));
  if (!f.detail.empty()) line += ": " + visible(f.detail);
  return line;
}

/// One check of one rig: its findings, and whether they decide.
Case check_case(const RigResult& rig, const std::string& code, const Coverage* coverage,
                const std::vector<const Finding*>& findings, const Digest& digest) {
  Case c;
  c.class_name = rig.character + "." + rig.rig + "." + rig.mapping;
  c.name = code;
  if (!digest.check_name(code).empty()) c.name += ' ' + digest.check_name(code);
  const auto raise = [&](CaseOutcome outcome, const std::string& message) {
    const bool first = c.message.empty();
    // failed outranks error outranks skipped: the first reason of the highest rank is the message.
    const auto rank = [](CaseOutcome o) {
      return o == CaseOutcome::failed    ? 3
             : o == CaseOutcome::error   ? 2
             : o == CaseOutcome::skipped ? 1
                                         : 0;
    };
    if (!first && rank(outcome) <= rank(c.outcome)) return;
    c.outcome = outcome;
    c.message = message;
  };
  const bool decides = rig.role == Role::proposed;
  for (const Finding* f : findings) {
    if (f->verdict == Verdict::pass) continue;
    const std::string line = line_of(*f);
    c.text += line + '\n';
    if (!f->reproduce.empty()) c.text += "  " + visible(f->reproduce) + '\n';
    if (decides && f->verdict == Verdict::fail)
      raise(CaseOutcome::failed, line);
    else if (decides && f->verdict == Verdict::not_measured)
      raise(CaseOutcome::error, line);
    else
      raise(CaseOutcome::skipped,
            decides ? line
                    : std::string(rig.role == Role::reference ? "comparison rig"
                                                              : role_word(rig.role)) +
                          ", does not decide: " + line);
  }
  if (coverage && coverage->not_measured > 0) {
    const std::string line = "not measured: " + std::to_string(coverage->not_measured) + " of " +
                             std::to_string(coverage->planned);
    c.text += line + '\n';
    raise(decides ? CaseOutcome::error : CaseOutcome::skipped, line);
  }
  if (coverage && coverage->planned == coverage->not_applicable)
    raise(CaseOutcome::skipped, "not applicable");
  return c;
}

std::vector<Case> rig_cases(const RigResult& rig, const Report& report, const Digest& digest) {
  const auto number = &rig - report.rigs.data();
  std::map<std::string, std::vector<const Finding*>> by_code;
  std::map<std::string, const Coverage*> coverage;
  for (const Coverage& c : rig.coverage) {
    coverage[c.code] = &c;
    by_code[c.code];
  }
  for (const Finding& f : report.findings)
    if (f.at.rig == number) by_code[f.code].push_back(&f);
  std::vector<Case> cases;
  for (const auto& [code, findings] : by_code)
    cases.push_back(check_case(rig, code, coverage.contains(code) ? coverage[code] : nullptr,
                               findings, digest));
  return cases;
}

std::vector<Case> canary_cases(const Report& report) {
  std::vector<Case> cases;
  for (const CanaryResult& c : report.canaries) {
    Case row{"canaries", c.rig + " " + c.code, c.ok() ? CaseOutcome::passed : CaseOutcome::failed,
             "", c.detail};
    if (!c.ok())
      row.message = c.found ? "the repaired twin is not clean" : "the planted fault was not found";
    cases.push_back(row);
  }
  return cases;
}

/// Exit code 0 is a pass and 1 is what the other suites show; any other ends here.
Case run_case(const Report& report) {
  Case c{"run", "verdict", CaseOutcome::passed, "", ""};
  for (const std::string& reason : report.reasons) c.text += visible(reason) + '\n';
  c.message = std::string(verdict_word(report.verdict)) + ": " + report.headline + " (exit code " +
              std::to_string(report.exit_code) + ")";
  if (report.exit_code == 1)
    c.outcome = CaseOutcome::failed;
  else if (report.exit_code != 0)
    c.outcome = CaseOutcome::error;
  return c;
}

}  // namespace

std::string junit_xml(const Report& report) {
  const Digest digest(report);
  std::string suites = xml("run", {run_case(report)});
  if (!report.canaries.empty()) suites += xml("canaries", canary_cases(report));
  for (const RigResult& rig : report.rigs)
    suites +=
        xml(rig.character + " " + rig.rig + " " + rig.mapping, rig_cases(rig, report, digest));
  return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites" +
         attribute("name", report.title) + ">\n" + suites + "</testsuites>\n";
}

}  // namespace backbend::validate
