#include "validate/judge/verdict.h"

#include <algorithm>
#include <set>

#include "skin/character/printable.h"
#include "validate/model/digest.h"
#include "validate/sweeps/sweep.h"
#include "validate/verdicts/checks.h"
#include "validate/verdicts/exit_code.h"

namespace backbend::validate {
namespace {

/// What fails on the rig of that number.
std::vector<const Finding*> failures_of(const Report& report, std::size_t rig) {
  std::vector<const Finding*> out;
  for (const Finding& finding : report.findings)
    if (finding.at.rig == static_cast<int>(rig) && finding.verdict == Verdict::fail)
      out.push_back(&finding);
  return out;
}

/// The parts of the envelope that no pose has measured: `side to 60, measured to 45`.
std::string envelope_gaps(const RigResult& rig) {
  std::string text;
  const auto add = [&](const std::string& gap) { text += (text.empty() ? "" : "; ") + gap; };
  for (const Headroom& h : rig.headroom) {
    if (h.covered()) continue;
    add(h.channel + " to " + number_text(h.needs_deg) +
        (h.measured ? ", measured to " + number_text(h.tested_to_deg) : ", not measured"));
  }
  if (!rig.corners.covered()) add("its corners, not measured");
  return text;
}

/// Whether a check that decides went without some of its measurements.
bool is_gap(const Coverage& each) {
  const Check* check = find_check(each.code);
  return each.not_measured > 0 && check != nullptr && check->decides;
}

/// The checks of a rig that decide and were not measured everywhere: "BB030 cross-section
/// collapse (419 of 419 poses)".
std::string gaps_text(const RigResult& rig) {
  std::string out;
  for (const Coverage& each : rig.coverage)
    if (is_gap(each))
      out += (out.empty() ? "" : ", ") + each.code + " " +
             std::string(find_check(each.code)->name) + " (" + std::to_string(each.not_measured) +
             " of " + std::to_string(each.planned) + ")";
  return out;
}

Verdict verdict_of(const RigResult& rig, bool fails) {
  if (fails) return Verdict::fail;
  const bool gap = std::any_of(rig.coverage.begin(), rig.coverage.end(), is_gap);
  return gap || rig.coverage.empty() || !envelope_gaps(rig).empty() ? Verdict::not_measured
                                                                    : Verdict::pass;
}

/// On a character that may have been misunderstood nothing passes and nothing fails: what was
/// found is shown, and who decides is whoever confirms it.
std::set<std::string> hold_back(Report& report) {
  std::set<std::string> names;
  for (const CharacterFacts& facts : report.characters) {
    if (facts.doubts.empty()) continue;
    names.insert(facts.name);
    std::string text = facts.name + ": not judged before backbend inspect --save confirms it: ";
    for (std::size_t i = 0; i < facts.doubts.size(); ++i)
      text += (i > 0 ? "; " : "") + facts.doubts[i];
    report.reasons.push_back(std::move(text));
  }
  for (Finding& finding : report.findings)
    if (finding.verdict == Verdict::fail && names.contains(finding.character))
      finding.verdict = Verdict::stress;
  return names;
}

std::string rig_text(const RigResult& rig) {
  return rig.mapping.empty() ? rig.rig : rig.rig + " (" + rig.mapping + ")";
}

}  // namespace

void conclude(Report& report) {
  bool failed = false, gap = false, proposed = false;
  const std::set<std::string> doubtful = hold_back(report);
  for (std::size_t r = 0; r < report.rigs.size(); ++r) {
    RigResult& rig = report.rigs[r];
    const std::vector<const Finding*> failures = failures_of(report, r);
    rig.verdict = doubtful.contains(rig.character) ? Verdict::not_measured
                                                   : verdict_of(rig, !failures.empty());
    if (rig.role != Role::proposed) continue;
    proposed = true;
    failed = failed || rig.verdict == Verdict::fail;
    gap = gap || rig.verdict == Verdict::not_measured;
    if (!failures.empty()) {
      const Finding* worst = *std::ranges::max_element(
          failures, {}, [](const Finding* finding) { return times_over(*finding); });
      const std::string place = place_text(*worst);
      report.reasons.push_back(
          rig_text(rig) + ": " + skin::plural(failures.size(), "finding") + ", worst " +
          worst->code + " " + std::string(find_check(worst->code)->name) + " " +
          value_text(*worst) + " at " + worst->pose + (place.empty() ? "" : ", " + place));
    } else if (rig.verdict == Verdict::not_measured && !doubtful.contains(rig.character) &&
               envelope_gaps(rig).empty()) {
      report.reasons.push_back(rig_text(rig) +
                               ": not everything that decides was measured: " + gaps_text(rig));
    }
    if (const std::string gaps = envelope_gaps(rig); !gaps.empty()) {
      gap = true;
      report.reasons.push_back(rig_text(rig) + ": the envelope needs " + gaps);
    }
  }
  for (const CanaryResult& canary : report.canaries) {
    if (canary.ok()) continue;
    gap = true;
    report.reasons.push_back("BB000 canary " + canary.rig + ": " + canary.detail);
  }
  for (const CalibrationRow& row : report.calibration) gap = gap || !row.ok;
  if (!proposed) {
    gap = true;
    report.reasons.emplace_back("no rig is proposed: nothing was judged");
  }
  report.verdict = failed ? Verdict::fail : gap ? Verdict::not_measured : Verdict::pass;
  const bool bad_input =
      std::any_of(report.findings.begin(), report.findings.end(), [](const Finding& finding) {
        return finding.owner == Owner::input && finding.verdict == Verdict::not_measured;
      });
  report.exit_code =
      first_exit_code({bad_input ? kExitBadInput : kExitOk, failed ? kExitFindings : kExitOk,
                       gap ? kExitNotMeasured : kExitOk});
  std::size_t poses = 0;
  for (const RigResult& rig : report.rigs) {
    for (const SweepSeries& sweep : rig.sweeps) poses += sweep.control_deg.size();
  }
  report.headline = skin::plural(poses, "pose") + " measured, " +
                    skin::plural(report.characters.size(), "character") + ", " +
                    skin::plural(report.rigs.size(), "rig") + " (mappings counted apart), " +
                    skin::plural(report.canaries.size(), "canary run");
}

}  // namespace backbend::validate
