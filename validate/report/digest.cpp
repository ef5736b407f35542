#include "validate/report/digest.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "validate/report/number_text.h"

namespace backbend::validate {
namespace {

/// Rank of a finding in `worst`; lower comes first, 3 is never shown.
int rank(const Finding& f, Role role) {
  const bool silent = f.verdict == Verdict::pass || f.verdict == Verdict::not_applicable;
  if (silent || role == Role::canary) return 3;
  if (role == Role::reference) return 2;
  return f.verdict == Verdict::fail ? 0 : 1;
}

}  // namespace

Digest::Digest(const Report& report) : report_(report) {
  for (const RigResult& rig : report.rigs) role_[{rig.character, rig.rig, rig.mapping}] = rig.role;
  for (const CheckLegend& check : report.checks) name_[check.code] = check.name;
  for (const RigResult& rig : report.rigs) {
    if (rig.role != Role::proposed) continue;
    for (const Coverage& c : rig.coverage) {
      counts_.not_measured += c.not_measured;
      counts_.not_applicable += c.not_applicable;
    }
    // What the envelope needs and no sweep reaches.
    for (const Headroom& h : rig.headroom) counts_.not_measured += h.covered() ? 0 : 1;
    counts_.not_measured += rig.corners.covered() ? 0 : 1;
  }
  for (const Finding& f : report.findings) {
    const Role role = role_of(f);
    if (f.verdict == Verdict::pass) continue;
    counts_.reference += role == Role::reference;
    counts_.canary += role == Role::canary;
    if (role != Role::proposed) continue;
    counts_.fail += f.verdict == Verdict::fail;
    counts_.waived += f.verdict == Verdict::waived;
    counts_.stress += f.verdict == Verdict::stress;
  }
}

Role Digest::role_of(const Finding& finding) const {
  const auto found = role_.find({finding.character, finding.rig, finding.mapping});
  return found == role_.end() ? Role::proposed : found->second;
}

const std::string& Digest::check_name(const std::string& code) const {
  static const std::string kNone;
  const auto found = name_.find(code);
  return found == name_.end() ? kNone : found->second;
}

std::vector<const Finding*> Digest::worst(std::size_t count) const {
  std::vector<const Finding*> out;
  std::set<const Finding*> taken;
  for (const bool repeat : {false, true})
    for (int wanted = 0; wanted < 3; ++wanted) {
      std::set<std::pair<std::string, std::string>> seen;
      for (const Finding& f : report_.findings) {
        if (out.size() == count) return out;
        if (rank(f, role_of(f)) != wanted || taken.contains(&f)) continue;
        if (!repeat && !seen.insert({f.code, f.rig}).second) continue;
        taken.insert(&f);
        out.push_back(&f);
      }
    }
  return out;
}

std::string place_text(const Finding& finding) {
  std::string text = finding.joint;
  const auto add = [&text](const std::string& part) { text += (text.empty() ? "" : ", ") + part; };
  if (finding.slice >= 0) add("slice " + std::to_string(finding.slice));
  if (finding.vertex >= 0) add("vertex " + std::to_string(finding.vertex));
  return text;
}

std::string value_text(const Finding& finding) {
  if (!std::isfinite(finding.value)) return "not measured";
  std::string text = significant(finding.value);
  if (std::isfinite(finding.limit)) {
    // Limits are upper or lower by the check's nature; the numbers say which one was passed.
    const char* relation = finding.value > finding.limit   ? " > "
                           : finding.value < finding.limit ? " < "
                                                           : " = ";
    text += relation + significant(finding.limit);
  }
  return finding.unit.empty() ? text : text + ' ' + finding.unit;
}

}  // namespace backbend::validate
