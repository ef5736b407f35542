#include "validate/clips/clip_run.h"

#include <algorithm>
#include <cmath>

#include "skin/anatomy/anatomy_hints.h"
#include "skin/character/matrix_facts.h"
#include "skin/character/printable.h"
#include "validate/clips/clip_canary.h"
#include "validate/clips/clip_frames.h"
#include "validate/clips/clip_input.h"
#include "validate/clips/clip_pictures.h"
#include "validate/clips/clip_sensitivity.h"
#include "validate/evidence/artist.h"
#include "validate/files/hash.h"
#include "validate/judge/confirmed.h"
#include "validate/judge/judge_recorded.h"
#include "validate/judge/owner.h"
#include "validate/judge/place.h"
#include "validate/judge/verdict.h"
#include "validate/night/run.h"
#include "validate/report/libraries.h"
#include "validate/tasks/pictures_ahead.h"

namespace backbend::validate {
namespace {

using Index = std::size_t;
using skin::CharacterError;

// Linear blending this near to a rig's own deformers (share of the spine's length) says the same
// about the body: the limits on it are ten times as wide.
constexpr double kTrustedBlending = 0.01;

/// The spine that is named, on a skeleton without a body; found where nothing is named and it is
/// sure.
skin::Anatomy skeleton_anatomy(const skin::Character& character, const skin::AnatomyHints& hints) {
  skin::Anatomy out;
  if (hints.spine.empty() && hints.hip.empty() && hints.chest.empty()) {
    try {
      out = skin::find_anatomy(character, hints);
      if (out.sure()) return out;
    } catch (const CharacterError&) {  // what is said below is the way out
    }
    out = {};
  }
  const skin::HintedSpine spine = skin::resolve_spine_hints(character, hints);
  out.spine = spine.chain;
  if (out.spine.empty() && spine.hip >= 0 && spine.chest >= 0)
    for (int node = spine.chest; node >= 0;
         node = character.nodes[static_cast<Index>(node)].parent) {
      out.spine.insert(out.spine.begin(), node);
      if (node == spine.hip) break;
    }
  if (out.spine.size() < 2 || (spine.hip >= 0 && out.spine.front() != spine.hip))
    throw CharacterError(character.file_name +
                         ": cannot find the spine of a skeleton without a body; specify "
                         "--spine, or --hip and --chest, or in the clip's header");
  const skin::HintedArms arms = skin::resolve_arm_hints(character, hints);
  out.left_arm = arms.left;
  out.right_arm = arms.right;
  out.chest_index = out.spine.size() - 1;
  out.head = out.spine.back();
  glm::dvec3 low(0.0), high(0.0);
  for (Index n = 0; n < character.nodes.size(); ++n) {
    const glm::dvec3 place = skin::origin(character.nodes[n].world_from_node);
    low = n == 0 ? place : glm::min(low, place);
    high = n == 0 ? place : glm::max(high, place);
  }
  out.height = glm::length(high - low);
  for (Index k = 1; k < out.spine.size(); ++k) {
    const auto at = [&](Index i) {
      return skin::origin(character.nodes[static_cast<Index>(out.spine[i])].world_from_node);
    };
    out.spine_length += glm::distance(at(k - 1), at(k));
  }
  if (!(out.spine_length > 0.0))
    throw CharacterError(character.file_name + ": the spine's joints stand in one place");
  return out;
}

skin::AnatomyHints with_clip(skin::AnatomyHints hints, const skin::Clip& clip) {
  if (hints.spine.empty() && hints.hip.empty() && hints.chest.empty()) hints.spine = clip.spine;
  if (hints.left_arm.empty()) hints.left_arm = clip.left_arm;
  if (hints.right_arm.empty()) hints.right_arm = clip.right_arm;
  return hints;
}

std::string blending_note(double error, double spine_length) {
  // Characters are in metres.
  const std::string head =
      "LBS against your deformers: p99 " + number_text(1000.0 * error, 1) + " mm: ";
  return head + (error <= kTrustedBlending * spine_length
                     ? "trusted"
                     : "mesh findings under LBS are not about your rig; here its own points are "
                       "measured");
}

const PoseRecord& pose_of(const RigRecord& record, const Finding& finding) {
  return sweep_of(record, finding)->poses[static_cast<Index>(finding.at.pose)];
}

/// What to set in the artist's program, where the clip says which channels moved and the sidecar
/// which controls they are.
void say_to_artist(const std::optional<skin::Sidecar>& sidecar, const skin::Clip& clip,
                   const RigRecord& record, std::vector<Finding>& findings) {
  if (!sidecar) return;
  for (Finding& finding : findings) {
    const Index frame = frame_of(pose_of(record, finding));
    PoseDegrees pose;
    for (Index k = 0; k < clip.control.size(); ++k) {
      const double value = control_value(clip, frame, k);
      double* const channel = pose.find(clip.control[k]);
      if (channel != nullptr && std::isfinite(value)) *channel = value;
    }
    finding.artist = artist_lines(*sidecar, pose);
  }
}

/// Fills in the place on the body of every finding. `metrics` is null without a body.
void name_places(const Stage& stage, const BodyMetrics* metrics, const ClipBody& body,
                 const RigRecord& record, std::vector<Finding>& findings) {
  const PlaceNames names(stage.character(), stage.anatomy(), metrics);
  for (Finding& finding : findings) {
    const bool posed = finding.slice >= 0 && metrics != nullptr;
    names.name(
        posed ? body.mesh(frame_of(pose_of(record, finding))).position : std::vector<glm::vec3>{},
        finding);
  }
}

/// `metrics` is null for a skeleton without a body.
Report judge_body(const ClipRequest& request, const ClipInput& input, const Stage& stage,
                  const BodyMetrics* metrics, Progress& progress) {
  const PicturesAhead pictures_ahead;  // the report's versions need the library
  const skin::Clip& clip = input.clip;
  const skin::Character& character = stage.character();
  const skin::Anatomy& anatomy = stage.anatomy();
  Report report;
  report.suite = "check";
  report.title =
      "Judging YOUR RIG: the motion of " + clip.file_name + " on " +
      (metrics == nullptr ? "its own joints (no body was given: chain only)" : character.file_name);
  report.provenance["clip " + clip.name] = hash_text(clip.content_hash_high, clip.content_hash_low);
  const ClipBody body(character, anatomy, clip, request.names);

  report.characters.push_back(facts_of(character, anatomy, "the clip"));
  CharacterFacts& facts = report.characters.back();
  report.provenance["character " + facts.name] = facts.hash;
  facts.notes.push_back(std::to_string(clip.frame_count()) + " frames in " +
                        std::to_string(clip.sweeps.size()) +
                        (clip.sweeps.size() == 1 ? " sweep" : " sweeps") +
                        (clip.source.empty() ? "" : ", from " + clip.source));
  for (const skin::Warning& warning : clip.warnings) facts.notes.push_back(warning.message);
  for (const std::string& note : body.notes()) facts.notes.push_back(note);
  if (const double error = body.blending_error(); std::isfinite(error))
    facts.notes.push_back(blending_note(error, anatomy.spine_length));
  if (metrics != nullptr)
    for (std::string& why : metrics->why_not()) facts.notes.push_back(std::move(why));
  if (const double bent = bend_at_rest(clip, anatomy, body); bent > 0.0)
    facts.notes.push_back(
        "not written from the rest pose: with all recorded controls at 0 the spine "
        "is bent by " +
        number_text(bent, 1) + " deg against the body's bind pose; angles count from there");
  if (request.on_character) request.on_character(report.title, facts);

  RigRecord record = measure_clip(stage, clip, body, metrics, progress);
  record.recording->command = request.command;
  facts.notes.insert(facts.notes.end(), record.recording->notes.begin(),
                     record.recording->notes.end());
  const LimitSet limits = clip_limits();
  const Envelope envelope = *find_envelope("sweep");
  const JudgeContext context{stage, limits, envelope, ""};
  report.findings = judge_rig(record, context);
  if (metrics != nullptr) book_owners(stage, *metrics, record, false, report.findings);
  std::ranges::stable_partition(
      report.findings, [](const Finding& finding) { return finding.verdict == Verdict::fail; });
  name_places(stage, metrics, body, record, report.findings);
  say_to_artist(input.sidecar, clip, record, report.findings);
  report.rigs.push_back(result_of(record, context, report.findings));
  for (Finding& finding : report.findings) finding.at.rig = 0;
  report.checks = legend(report, limits);
  if (metrics != nullptr && !request.folder.empty() && request.pictures.enabled)
    make_clip_pictures({stage, *metrics, body, record, PlaceNames(character, anatomy, metrics)},
                       request.pictures, OutputFolder(request.folder), progress, report);
  if (std::ranges::any_of(clip.sweeps,
                          [](const skin::ClipSweep& sweep) { return sweep.count >= 10; }))
    report.canaries.push_back(clip_canary(record, clip, body, anatomy));
  for (std::string& line : clip_sensitivity(record)) report.detectors.push_back(std::move(line));
  if (!report.findings.empty()) report.next = {"backbend explain " + report.findings.front().code};
  if (!facts.doubts.empty())
    report.next.insert(
        report.next.begin(),
        confirm_command(request.character.empty() ? request.clip : request.character));
  // Captured or keyed motion has no rig that could be asked.
  if (is_better_asked_live(record) && record.recording->owner == Owner::rig)
    report.next.push_back(live_command(clip, request.character));
  report.provenance.merge(program_versions());
  conclude(report);
  return report;
}

}  // namespace

Report run_clip(const ClipRequest& request, Progress& progress) {
  ClipInput input = read_clip_input(request);
  if (input.stage != nullptr) {
    const Stage& stage = *input.stage;
    const BodyMetrics metrics(stage.character(), stage.anatomy(), stage.driver());
    return judge_body(request, input, stage, &metrics, progress);
  }
  skin::Character skeleton = bare_skeleton(input.clip);
  skin::Anatomy anatomy =
      up_to_the_neck(skeleton, skeleton_anatomy(skeleton, with_clip(input.hints, input.clip)));
  const Stage stage(std::move(skeleton), std::move(anatomy));
  return judge_body(request, input, stage, nullptr, progress);
}

}  // namespace backbend::validate
