#include "validate/night/standard_runs.h"

#include "skin/character/character.h"
#include "validate/compare/comparison.h"
#include "validate/files/data_folder.h"
#include "validate/files/output_folder.h"
#include "validate/sweeps/external_spec.h"

namespace backbend::validate {

namespace fs = std::filesystem;

RigPlan isner_canary() {
  RigPlan plan;
  plan.name = "isner_flip";
  plan.spec.system = "isner";
  plan.role = Role::canary;
  CanaryDuty duty;
  duty.code = "BB001";
  duty.sweep = "extension";
  duty.joint = "top_vertebra";
  duty.control_deg = 114.3;
  duty.tolerance_deg = 0.3;
  duty.twin.system = "matrix_blend";
  plan.duty = duty;
  return plan;
}

void sweep_as_named(const std::string& name, Suite& suite) {
  suite.standard = name != "stress";
  suite.corners = true;
  if (suite.standard) {
    suite.sweeps = standard_sweeps(suite.envelope);
    return;
  }
  suite.sweeps = stress_sweeps();
  for (Sweep& sweep : grid_sweeps()) suite.sweeps.push_back(std::move(sweep));
}

DrivenChain driven_chain(const std::string& chain, const RigPlan& rig,
                         const skin::AnatomyHints& hints) {
  const bool named = !hints.hip.empty() || !hints.chest.empty() || !hints.spine.empty();
  if (chain.empty())
    return rig.spec.system == "neck" && !named ? DrivenChain::neck : DrivenChain::spine;
  return chain == "neck" ? DrivenChain::neck : DrivenChain::spine;
}

RunRequest check_request(const CheckWishes& wishes) {
  RunRequest request;
  Suite& suite = request.suite;
  suite.name = "check";
  suite.characters = {wishes.character};
  suite.rigs = {wishes.rig, isner_canary()};
  suite.mappings = {wishes.mapping};
  suite.envelope_by_kind = wishes.envelope == kEnvelopeByKind;
  suite.envelope = *find_envelope(suite.envelope_by_kind ? "human" : wishes.envelope);
  sweep_as_named(wishes.sweeps, suite);
  suite.pictures.sheet_columns = 0;
  suite.judges_weights = true;
  request.hints = wishes.hints;
  request.chain = driven_chain(wishes.chain, wishes.rig, wishes.hints);
  request.character = wishes.character;
  // Under the ideal bend what is wrong is the weights'; under any other rig it may be either's.
  const bool external = is_external(wishes.rig.spec);
  request.title = (wishes.rig.spec.system == "even" ? "Judging the WEIGHTS of "
                                                    : "Judging the RIG and the WEIGHTS of ") +
                  fs::path(wishes.character).filename().string() +
                  (external ? " with your rig '" : " with our rig '") + wishes.rig.name + "'";
  return request;
}

namespace {

/// Random poses that say how much of the envelope is clean on each side of a comparison: where all
/// are, that is 97 % of it at least.
constexpr int kComparedSamples = 100;

}  // namespace

RunRequest compare_rigs_request(const RigComparisonWishes& wishes) {
  RunRequest request;
  Suite& suite = request.suite;
  suite.name = "compare";
  suite.rigs = {wishes.proposed, wishes.reference, isner_canary()};
  suite.rigs[1].role = Role::reference;
  if (suite.rigs[0].name == suite.rigs[1].name) suite.rigs[1].name += "_2";
  suite.title = suite.rigs[0].name + " against " + suite.rigs[1].name;
  const fs::path bundled = read_suite(data_folder() / "scenes" / "nightly.toml").characters.front();
  suite.characters = {wishes.character.empty() ? bundled : fs::path(wishes.character)};
  suite.mappings = {wishes.mapping};
  suite.pictures.sheet_columns = 0;  // the worst frames of both sides are what it is made for
  suite.envelope = *find_envelope("sweep");
  sweep_as_named(wishes.sweeps, suite);
  suite.standard = false;  // they are those already, for every character
  // Pictures of every pose are what takes time: they follow the bends, and findings elsewhere.
  for (Sweep& sweep : suite.sweeps)
    sweep.watched =
        sweep.watched && (moves_alone(sweep, "extension") || moves_alone(sweep, "flexion"));
  suite.hunt.samples = kComparedSamples;
  request.compare = RunRequest::Compare::rigs;
  request.character = wishes.character.empty() ? "scenes/characters/human.toml" : wishes.character;
  return request;
}

RunRequest compare_characters_request(const CharacterComparisonWishes& wishes) {
  for (const std::string& file : {wishes.first, wishes.second})
    if (!fs::exists(file)) throw skin::CharacterError(file + ": no such file");
  RunRequest request;
  Suite& suite = request.suite;
  suite.name = "compare";
  const auto [first, second] = side_labels(wishes.first, wishes.second);
  suite.title = second + " against " + first;
  suite.characters = {wishes.first, wishes.second};
  suite.rigs = {wishes.rig, isner_canary()};
  suite.mappings = {wishes.mapping};
  suite.pictures.sheet_columns = 0;
  suite.envelope = *find_envelope("human");
  suite.envelope_by_kind = true;
  sweep_as_named(wishes.sweeps, suite);
  suite.judges_weights = true;
  suite.hunt.samples = kComparedSamples;
  request.compare = RunRequest::Compare::characters;
  return request;
}

Report run_request(const RunRequest& request, Progress& progress) {
  if (request.folder.empty()) return run_suite(request, progress);
  OutputFolder(request.folder).prepare();
  const FolderLock lock(request.folder, FolderLock::Kind::exclusive);
  Report report = run_suite(request, progress);
  write_report(report, request.folder);
  return report;
}

}  // namespace backbend::validate
