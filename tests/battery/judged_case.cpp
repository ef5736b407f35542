#include "tests/battery/judged_case.h"

#include "skin/character/character.h"
#include "validate/clips/clip_run.h"
#include "validate/night/run.h"
#include "validate/sweeps/suite.h"
#include "validate/verdicts/exit_code.h"

namespace backbend::battery {
namespace {

using namespace validate;

template <typename Run>
Outcome outcome_of(const Run& run) {
  Outcome out;
  try {
    const Report report = run();
    out.exit_code = report.exit_code;
    out.reasons = report.reasons;
    for (const RigResult& rig : report.rigs)
      out.worst.insert(rig.summary.begin(), rig.summary.end());
    for (const Finding& finding : report.findings)
      if (finding.verdict == Verdict::fail) out.failing.push_back(finding);
  } catch (const skin::CharacterError& error) {
    out.exit_code = kExitBadInput;
    out.refused = error.what();
  }
  return out;
}

}  // namespace

Outcome check_character(const std::filesystem::path& file) {
  return outcome_of([&] {
    RunRequest request;
    Suite& suite = request.suite;
    suite.name = "check";
    suite.characters = {file};
    suite.rigs = {read_rig("even")};
    suite.mappings = {solver::Mapping::chest};
    suite.envelope_by_kind = true;
    suite.envelope = *find_envelope("human");
    suite.standard = suite.corners = true;
    suite.sweeps = standard_sweeps(suite.envelope);
    suite.pictures.enabled = false;
    suite.judges_weights = true;
    request.image_pass = false;
    request.character = file;
    Progress progress(Progress::Style::none);
    return run_suite(request, progress);
  });
}

Outcome check_clip(const std::filesystem::path& character, const std::filesystem::path& clip) {
  return outcome_of([&] {
    ClipRequest request;
    request.character = character;
    request.clip = clip;
    request.command = "backbend check";
    Progress progress(Progress::Style::none);
    return run_clip(request, progress);
  });
}

}  // namespace backbend::battery
