#include <algorithm>

#include "validate/evidence/artist.h"
#include "validate/evidence/finding_view.h"
#include "validate/evidence/render_job.h"
#include "validate/files/hash.h"
#include "validate/files/program_hash.h"
#include "validate/hunt/hunt.h"
#include "validate/judge/judge_external.h"
#include "validate/judge/searched_character.h"
#include "validate/live/external_rig.h"
#include "validate/sweeps/external_spec.h"
#include "validate/sweeps/named_pose.h"
#include "validate/text/number_text.h"
#include "validate/text/shell_word.h"
#include "validate/verdicts/exit_code.h"

namespace backbend::validate {
namespace {

/// One picture of a find, from the side that shows it; the file's name.
std::string take_picture(const HuntRequest& request, const HuntFind& find, std::size_t number,
                         const OutputFolder& folder) {
  RenderRequest picture;
  picture.character = request.character;
  picture.hints = request.hints;
  picture.chain = request.chain;
  picture.rig = request.rig;
  picture.mapping = request.mapping;
  picture.pose = find.pose;
  picture.view = view_of(find.pose, find.finding).camera;
  picture.settings.width = request.width;
  picture.settings.height = request.height;
  picture.settings.samples = 16;
  picture.name = "hunt_" + std::to_string(number) + "_" + find.finding.code;
  Progress silent(Progress::Style::none);
  render_pose(picture, folder, silent);
  return picture.name + ".png";
}

/// Everything that the points of a hunt depend on, and what they are.
std::string stamp_of(const HuntRequest& request, const HuntResult& out, const HuntSettings& s,
                     const LimitSet& limits) {
  std::string text = program_hash() + "\n" + out.facts.hash + "\n" + rig_text(request.rig.spec) +
                     "\n" + out.mapping + "\n" + out.facts.envelope + "\n" + s.check + "\n" +
                     std::to_string(s.evaluations) + " " + std::to_string(s.seed);
  if (is_external(request.rig.spec)) text += "\n" + external_inputs(request.rig.spec);
  for (const auto* joints : {&out.facts.spine, &out.facts.left_arm, &out.facts.right_arm})
    for (const std::string& joint : *joints) text += "\n" + joint;
  for (const BoxAxis& axis : s.box.axes)
    text += "\n" + axis.name + " " + shortest(axis.low) + " " + shortest(axis.high);
  text += "\n" + pose_words(s.box.held);
  for (const std::string& code : huntable_checks())
    text += "\n" + code + " " + shortest(limits.of(code).value);
  return content_hash(text);
}

}  // namespace

int HuntResult::exit_code() const {
  if (!facts.doubts.empty()) return kExitNotMeasured;  // it may have been misunderstood
  for (const HuntFind& find : hunt.finds)
    if (find.finding.verdict == Verdict::fail) return kExitFindings;
  // Flips are asked of every pose, whatever else the rig has a measure for.
  const bool measured = !hunt.worst.empty() || check == "BB001" || check == "BB002";
  return measured ? kExitOk : kExitNotMeasured;
}

HuntResult run_hunt(const HuntRequest& request, Progress& progress) {
  if (!request.folder.empty() && std::filesystem::exists(request.folder / kPlanFile))
    throw MixedPartsError(request.folder.string() +
                          ": holds a job that was stopped; use another folder, or remove its "
                          "'parts'");
  const SearchedCharacter searched =
      load_searched(request.character, request.hints, request.chain, request.rig, request.envelope);
  const Stage& stage = *searched.stage;
  const Envelope& envelope = searched.envelope;

  HuntResult out;
  out.facts = searched.facts;
  out.rig = request.rig.name;
  out.mapping = mapping_name(request.mapping);
  out.seed = request.seed;
  out.check = request.check;
  HuntSettings settings{find_box(request.box, envelope), request.check};
  settings.evaluations = request.evaluations;
  settings.seed = request.seed;
  if (request.on_character) request.on_character(out.facts, settings.box);

  LimitSet limits =
      request.suite ? limits_for(request.suite->rules, stage.character().name) : LimitSet();
  if (is_external(request.rig.spec)) limits = external_limits(std::move(limits));
  const BodyMetrics body(stage.character(), stage.anatomy(), stage.driver());
  const HuntScene scene{stage,
                        body,
                        envelope,
                        limits,
                        request.rig,
                        request.mapping,
                        shell_word(request.character.string()),
                        [&] { return stage.build(request.rig.spec); }};
  std::optional<Ledger> ledger;
  if (!request.folder.empty()) {
    ledger.emplace(request.folder, stamp_of(request, out, settings, limits), Ledger::Mode::alone,
                   Shard{}, request.resume);
    settings.ledger = &*ledger;
  }
  out.hunt = hunt_poses(scene, settings, progress);
  if (!out.facts.doubts.empty())
    for (HuntFind& find : out.hunt.finds) find.finding.verdict = Verdict::stress;
  for (HuntFind& find : out.hunt.finds)
    if (searched.sidecar) find.finding.artist = artist_lines(*searched.sidecar, find.pose);
  if (!request.folder.empty()) {
    const OutputFolder folder(request.folder);
    progress.start("pictures", out.hunt.finds.size());
    for (std::size_t i = 0; i < out.hunt.finds.size(); ++i) {
      poll_interrupt();
      HuntFind& find = out.hunt.finds[i];
      find.picture = take_picture(request, find, i + 1, folder);
      progress.step();
    }
    progress.finish();
    remove_parts(request.folder);
  }
  return out;
}

}  // namespace backbend::validate
