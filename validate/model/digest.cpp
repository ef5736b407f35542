#include "validate/model/digest.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "validate/text/number_text.h"

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
  return finding.at.rig < 0 ? Role::proposed
                            : report_.rigs[static_cast<std::size_t>(finding.at.rig)].role;
}

const std::string& Digest::check_name(const std::string& code) const {
  static const std::string kNone;
  const auto found = name_.find(code);
  return found == name_.end() ? kNone : found->second;
}

std::vector<const Finding*> Digest::worst(std::size_t count) const {
  std::vector<const Finding*> sorted;
  for (const Finding& f : report_.findings) sorted.push_back(&f);
  std::stable_sort(sorted.begin(), sorted.end(), [](const Finding* a, const Finding* b) {
    return times_over(*a) > times_over(*b);
  });
  std::vector<const Finding*> out;
  std::set<const Finding*> taken;
  for (const bool repeat : {false, true})
    for (int wanted = 0; wanted < 3; ++wanted) {
      std::set<std::pair<std::string, std::string>> seen;
      for (const Finding* f : sorted) {
        if (out.size() == count) return out;
        if (rank(*f, role_of(*f)) != wanted || taken.contains(f)) continue;
        if (!repeat && !seen.insert({f->code, f->rig}).second) continue;
        taken.insert(f);
        out.push_back(f);
      }
    }
  return out;
}

std::string clean_text(const Headroom& h) {
  if (!h.measured || !std::isfinite(h.clean_to_deg)) return "?";
  return fixed(h.clean_to_deg, 0) + (h.clean_to_deg >= h.tested_to_deg ? "+" : "");
}

std::string headroom_text(const std::vector<Headroom>& headroom) {
  std::string text;
  for (const Headroom& each : headroom)
    text += (text.empty() ? "" : ", ") + each.channel + " " + clean_text(each);
  return text;
}

std::string place_text(const Finding& finding) {
  std::string text;
  const auto add = [&text](const std::string& part) { text += (text.empty() ? "" : ", ") + part; };
  if (!finding.between[0].empty())
    add("between " + finding.between[0] + " and " + finding.between[1]);
  else if (!finding.joint.empty())
    add(finding.joint);
  if (!finding.side.empty()) add(finding.side);
  if (!finding.part.empty()) add("mesh \"" + finding.part + "\"");
  if (!text.empty()) return text;
  if (finding.slice >= 0) return "slice " + std::to_string(finding.slice);
  return finding.vertex >= 0 ? "vertex " + std::to_string(finding.vertex) : "";
}

std::string quantity_text(const Finding& finding, double value, int digits) {
  const std::string text = significant(value, digits);
  if (finding.code == "BB030") return text + " of rest";
  if (finding.unit == "ratio") return "x " + text;
  return finding.unit.empty() || finding.unit == "count" ? text : text + ' ' + finding.unit;
}

std::string value_text(const Finding& finding) {
  if (!std::isfinite(finding.value)) return "not measured";
  // Tenths of a degree where there are hundreds.
  int digits = std::abs(finding.value) >= 100.0 ? 4 : 3;
  if (!std::isfinite(finding.limit)) return quantity_text(finding, finding.value, digits);
  std::string limit = significant(finding.limit);
  constexpr int kMostDigits = 9;
  while (finding.value != finding.limit && digits < kMostDigits &&
         significant(finding.value, digits) == limit)
    ++digits;
  return quantity_text(finding, finding.value, digits) + " (limit " + limit + ")";
}

std::string finding_name(const Finding& finding, const Digest& digest) {
  if (finding.code == "BB030" && finding.pose.starts_with("twist ")) return "candy wrapper";
  return digest.check_name(finding.code);
}

std::string mapping_words(const std::string& mapping) {
  if (mapping == "chest") return "all on the chest control";
  return mapping == "spread" ? "spread over the controls" : mapping;
}

double times_over(const Finding& finding) {
  constexpr double kFloor = 1e-9;
  const double value = finding.value, limit = finding.limit;
  if (!std::isfinite(value) || !std::isfinite(limit)) return 0.0;
  return value > limit ? value / std::max(limit, kFloor) : limit / std::max(value, kFloor);
}

}  // namespace backbend::validate
