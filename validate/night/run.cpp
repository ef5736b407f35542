#include "validate/night/run.h"

#include <algorithm>
#include <map>
#include <optional>
#include <span>

#include "skin/anatomy/import_checks.h"
#include "skin/weights/inspect.h"
#include "validate/calibrate/calibrate.h"
#include "validate/compare/comparison.h"
#include "validate/compare/surface_match.h"
#include "validate/compare/worst_frames.h"
#include "validate/evidence/artist.h"
#include "validate/evidence/evidence.h"
#include "validate/evidence/timeline.h"
#include "validate/files/hash.h"
#include "validate/files/output_folder.h"
#include "validate/history/trend.h"
#include "validate/judge/canary.h"
#include "validate/judge/confirmed.h"
#include "validate/judge/judge.h"
#include "validate/judge/judge_deformers.h"
#include "validate/judge/judge_external.h"
#include "validate/judge/judge_input.h"
#include "validate/judge/owner.h"
#include "validate/judge/place.h"
#include "validate/judge/verdict.h"
#include "validate/live/control_lines.h"
#include "validate/live/external_rig.h"
#include "validate/measure/compound_search.h"
#include "validate/measure/measure_job.h"
#include "validate/model/digest.h"
#include "validate/model/report_json.h"
#include "validate/night/beside.h"
#include "validate/night/image_pass.h"
#include "validate/night/offer.h"
#include "validate/night/pose_hunt.h"
#include "validate/report/csv.h"
#include "validate/report/handoff.h"
#include "validate/report/headline_picture.h"
#include "validate/report/html.h"
#include "validate/report/junit.h"
#include "validate/report/libraries.h"
#include "validate/report/markdown.h"
#include "validate/sweeps/external_spec.h"
#include "validate/tasks/ahead.h"
#include "validate/tasks/pictures_ahead.h"
#include "validate/tasks/side_by_side.h"
#include "validate/text/shell_word.h"
#include "validate/verdicts/booking.h"

namespace backbend::validate {

std::vector<CheckLegend> legend(const Report& report, const LimitSet& limits) {
  std::vector<CheckLegend> rows;
  for (const Check& check : all_checks()) {
    const bool planned =
        std::any_of(report.rigs.begin(), report.rigs.end(), [&](const RigResult& rig) {
          return std::any_of(rig.coverage.begin(), rig.coverage.end(),
                             [&](const Coverage& each) { return each.code == check.code; });
        });
    const bool found =
        std::ranges::find(report.findings, check.code, &Finding::code) != report.findings.end();
    if (!planned && !found) continue;
    rows.push_back({std::string(check.code), std::string(check.name), std::string(check.measures),
                    std::string(check.unit), std::string(check.reason), limits.of(check.code).value,
                    std::string(name_of(check.sense))});
  }
  return rows;
}

namespace {

/// A character that cannot be used becomes a finding, so that the others still run.
Finding input_finding(const std::filesystem::path& file, const std::string& why) {
  Finding finding;
  finding.code = "BB051";
  finding.character = file.stem().string();
  finding.pose = "none";
  finding.unit = find_check(finding.code)->unit;
  finding.verdict = Verdict::not_measured;
  finding.owner = Owner::input;
  finding.detail = why;
  return finding;
}

/// The envelope of a character, and where it comes from.
struct EnvelopeChoice {
  Envelope envelope;
  std::string reason;
};

/// The suite's or the command line's; else the sidecar's; else that of the kind of body. A
/// project's envelope yields to the sidecar's.
EnvelopeChoice envelope_of(const RunRequest& request, const std::optional<skin::Sidecar>& sidecar,
                           const CharacterFacts& facts, skin::BodyKind kind) {
  const Suite& suite = request.suite;
  const auto chosen = [](Envelope envelope, const std::string& who) {
    std::string reason = who + ": " + envelope.reason;
    return EnvelopeChoice{std::move(envelope), std::move(reason)};
  };
  const bool own_counts = suite.envelope_by_kind || request.envelope_yields;
  if (own_counts && sidecar && !sidecar->envelope.empty())
    if (const auto own = find_envelope(sidecar->envelope)) return chosen(*own, "its sidecar");
  if (!suite.envelope_by_kind) return chosen(suite.envelope, "requested");
  if (request.chain == DrivenChain::neck)
    return chosen(envelope_for(kind, true), "the neck is driven");
  return chosen(envelope_for(kind, false), facts.kind_reason);
}

/// Adds what was found on the report's rig of that number.
void add_findings(std::vector<Finding> findings, std::ptrdiff_t rig, Report& report) {
  for (Finding& finding : findings) {
    finding.at.rig = static_cast<int>(rig);
    report.findings.push_back(std::move(finding));
  }
}

/// The file is judged once, under the first rig that decides, or the first at all.
void judge_file(const Suite& suite, const std::vector<RigRecord>& records,
                const JudgeContext& context, const InputReading& reading, const BodyMetrics& body,
                Report& report) {
  const auto decides = [](const RigRecord& each) { return each.plan.role == Role::proposed; };
  auto record = std::find_if(records.begin(), records.end(), decides);
  if (record == records.end()) record = records.begin();
  if (record == records.end()) return;
  InputJudgement input = judge_input(*record, context, reading, body, suite.judges_weights);
  const auto rig = report.rigs.end() - (records.end() - record);
  add_findings(std::move(input.findings), rig - report.rigs.begin(), report);
  for (const Coverage& each : input.coverage) rig->coverage.push_back(each);
  for (std::string& note : input.notes) report.characters.back().notes.push_back(std::move(note));
}

/// What both pictures and geometry cover: every sweep that is watched, and every
/// finding.
Coverage agreement_coverage(const RigRecord& rig, const std::vector<Finding>& findings) {
  const auto looked_at =
      std::ranges::count_if(rig.sweeps, [](const SweepRecord& each) { return each.sweep.watched; });
  Coverage out{"BB070", static_cast<int>(looked_at) + static_cast<int>(findings.size()), 0, 0, 0};
  out.not_applicable = static_cast<int>(std::ranges::count_if(
      findings, [](const Finding& finding) { return !finding.image.measured; }));
  out.measured = out.planned - out.not_applicable;
  return out;
}

/// How often pictures show what geometry found, by check.
std::string agreement_line(const std::vector<Finding>& findings) {
  struct Count {
    int seen = 0, unseen = 0;
  };
  std::map<std::string, Count> counts;
  int picture_only = 0;
  for (const Finding& finding : findings) {
    picture_only += static_cast<int>(finding.geometry.count("picture_only"));
    if (finding.image.measured)
      ++(finding.image.visible ? counts[finding.code].seen : counts[finding.code].unseen);
  }
  std::string line = "findings that pictures show as well:";
  for (const auto& [code, count] : counts)
    line += " " + code + " " + std::to_string(count.seen) + " of " +
            std::to_string(count.seen + count.unseen) + ",";
  if (counts.empty()) line += " none to look at,";
  return line + " and " + std::to_string(picture_only) + " jumps by pictures alone";
}

/// Fills in the place on the body of every finding of a rig.
void name_places(const Stage& stage, const PlaceNames& names, const RigRecord& record,
                 std::vector<Finding>& findings) {
  for (Finding& finding : findings) {
    const SweepRecord* sweep = sweep_of(record, finding);
    // Only the side of a slice needs the body in its pose.
    const bool posed = finding.slice >= 0 && sweep != nullptr;
    names.name(
        posed ? stage
                    .pose(*record.system,
                          controls_at(*record.system, sweep->sweep.pose_at(finding.control_deg),
                                      record.mapping))
                    .mesh.position
              : std::vector<glm::vec3>{},
        finding);
  }
}

/// Where it is known which of the artist's controls stand for which channel, by the mapping of a
/// live rig or by the sidecar, each finding gets the values to set.
void say_to_artist(const std::optional<skin::Sidecar>& sidecar, const RigRecord& record,
                   std::vector<Finding>& findings) {
  const ExternalRig* external = external_rig(*record.system);
  if (!external && !sidecar) return;
  for (Finding& finding : findings) {
    const SweepRecord* sweep = sweep_of(record, finding);
    if (sweep == nullptr) continue;
    const PoseDegrees pose = sweep->sweep.pose_at(finding.control_deg);
    finding.artist =
        external ? control_lines(*external, controls_at(*record.system, pose, record.mapping))
                 : artist_lines(*sidecar, pose);
  }
}

/// What a studio's own rig was asked beside its sweeps.
void take_external(const ExternalJudgement& external, RigResult& result) {
  for (const Coverage& asked : external.coverage) {
    const auto known = std::ranges::find(result.coverage, asked.code, &Coverage::code);
    if (known == result.coverage.end()) {
      result.coverage.push_back(asked);
      continue;
    }
    known->planned += asked.planned;
    known->measured += asked.measured;
    known->not_measured += asked.not_measured;
  }
  for (const auto& [channel, to_deg] : external.answered_to)
    for (Headroom& headroom : result.headroom) {
      if (headroom.channel != channel) continue;
      if (to_deg == 0.0) headroom.measured = false;
      headroom.clean_to_deg = std::min(headroom.clean_to_deg, to_deg);
    }
}

/// How far linear blending is from what a studio's own rig does, with the place on the body.
std::string blending_note(const RigRecord& rig, const BlendingDistance& distance,
                          const Stage& stage, const PlaceNames& places) {
  Finding where;
  where.vertex = distance.vertex;
  places.name({}, where);
  return "rig " + rig.plan.name + ": " +
         blending_text(distance, stage.anatomy().spine_length, place_text(where));
}

/// A character that was measured, for those who pose it again.
struct CharacterRun {
  std::unique_ptr<Stage> stage;
  std::vector<RigRecord> records;
  std::string character;  // its file as the user named it
  std::string words;      // that and its joints as commands name them
  render::Bounds box;     // of every pose
  bool numbered = false;  // its name is an earlier character's, too
};

/// Notes the sweeps that a rig cannot take, by their reason.
void say_what_is_left_out(const RigRecord& rig, std::vector<std::string>& notes) {
  std::map<std::string, std::string> sweeps;  // by reason
  for (const SweepRecord& record : rig.sweeps) {
    const std::string why = why_not_taken(*rig.system, record.sweep.pose_at(record.sweep.to_deg));
    if (!why.empty()) sweeps[why] += (sweeps[why].empty() ? "" : ", ") + record.sweep.name;
  }
  for (const auto& [why, names] : sweeps)
    notes.push_back("rig " + rig.plan.name + ", not applicable: " + names + " (" + why + ")");
}

/// What the search on compound poses found, for each rig of the suite.
struct RigSearches {
  std::vector<CompoundSearch> rig;
  std::vector<Sweep> around;  // every rig is measured where one of them jumps: all have these poses
};

RigSearches search_rigs(const Stage& stage, const Suite& suite, solver::Mapping mapping,
                        const Envelope& box, KnownJumps* known, Progress& progress) {
  RigSearches out;
  for (const RigPlan& plan : suite.rigs) {
    FoundJumps found;
    if (plan.role != Role::canary && suite.corners) {
      const auto system = stage.build(plan.spec);
      const ExternalRig* external = external_rig(*system);
      if (!external || !external->has_memory())
        found = known != nullptr ? known->compound(stage, plan, *system, mapping, box, progress)
                                 : search_compound(*system, mapping, box, &progress);
    }
    out.rig.push_back(found.summary);
    for (Sweep& sweep : found.around) {
      const auto is_there = [&](const Sweep& each) { return each.name == sweep.name; };
      if (std::ranges::none_of(out.around, is_there)) out.around.push_back(std::move(sweep));
    }
  }
  return out;
}

/// Says what our rigs leave unmoved, where it is more than a prop or corrective joints carry.
void note_coverage(const Stage& stage, CharacterFacts& facts) {
  constexpr double kProp = 0.05;        // of all weight
  constexpr double kCorrectives = 0.2;  // of the torso's
  skin::DriverCoverage coverage = skin::driver_coverage(stage.character(), stage.anatomy());
  if (coverage.helper_share < kCorrectives) coverage.helpers.clear();
  if (coverage.unreached_share < kProp) coverage.unreached.clear();
  for (std::string& line : skin::coverage_lines(stage.character(), coverage))
    facts.notes.push_back(std::move(line));
}

CharacterRun run_character(const RunRequest& request, const Suite& suite,
                           const std::filesystem::path& file, const OutputFolder& folder,
                           Ledger& ledger, Progress& progress, Report& report) {
  ConfirmedCharacter confirmed = load_confirmed(file, request.hints);
  skin::require_possible_import(confirmed.character);
  const PicturesAhead pictures_ahead;
  // Findings and pictures are named by the character: a second file of the same name gets a number.
  const std::string name = confirmed.character.name;
  const auto taken = [&](const CharacterFacts& each) {
    return each.name == confirmed.character.name;
  };
  for (int n = 2; std::any_of(report.characters.begin(), report.characters.end(), taken); ++n)
    confirmed.character.name = name + "_" + std::to_string(n);
  const bool numbered = confirmed.character.name != name;
  const std::vector<skin::SidecarControl> controls =
      confirmed.sidecar ? confirmed.sidecar->controls : std::vector<skin::SidecarControl>();
  CharacterRun run{std::make_unique<Stage>(std::move(confirmed.character), confirmed.hints,
                                           request.chain, controls),
                   {},
                   request.character_text(file),
                   request.character_words(file),
                   {},
                   numbered};
  for (const RigPlan& plan : suite.rigs) {
    auto with_its_mesh = run.stage->with_mesh_of(plan.spec);
    if (!with_its_mesh) continue;
    run.stage = std::make_unique<Stage>(std::move(*with_its_mesh), confirmed.hints, request.chain,
                                        controls);
    break;
  }
  const Stage& stage = *run.stage;
  const bool has_own_mesh = !has_mesh_of_rig(stage.character());
  const bool judges_weights = suite.judges_weights && has_own_mesh;
  report.characters.push_back(facts_of(stage.character(), stage.anatomy(), ""));
  CharacterFacts& facts = report.characters.back();
  // Of the whole body, whichever chain of it is driven.
  const skin::BodyKindChoice kind = skin::body_kind(
      stage.character(), request.chain == DrivenChain::neck
                             ? skin::find_anatomy(stage.character(), confirmed.hints)
                             : stage.anatomy());
  facts.kind = skin::name_of(kind.kind);
  facts.kind_reason = kind.reason;
  const EnvelopeChoice choice = envelope_of(request, confirmed.sidecar, facts, kind.kind);
  const Envelope& envelope = choice.envelope;
  facts.envelope = envelope.name;
  facts.envelope_reason = choice.reason + "; " + envelope.text();
  if (std::ranges::any_of(suite.rigs, [](const RigPlan& rig) {
        return rig.role != Role::canary && !is_external(rig.spec);
      }))
    note_coverage(stage, facts);
  if (request.on_character) request.on_character(report.characters.back());
  const LimitSet limits = limits_for(suite.rules, stage.character().name), table;
  const JudgeContext own_context{stage, limits, envelope, run.words};
  const LimitSet of_external = external_limits(limits);
  const JudgeContext external_context{stage, of_external, envelope, run.words};
  // Canaries always use the built-in limits.
  const JudgeContext by_the_table{stage, table, envelope, run.words};
  std::optional<Ahead<InputReading>> input;
  if (has_own_mesh) input.emplace([&stage] { return read_input(stage); });
  const BodyMetrics body(stage.character(), stage.anatomy(), stage.driver());
  for (std::string& why : body.why_not()) report.characters.back().notes.push_back(std::move(why));

  std::vector<RigRecord>& records = run.records;
  const std::vector<Sweep> sweeps = sweeps_for(suite, envelope);
  for (const solver::Mapping mapping : suite.mappings) {
    const RigSearches searches = search_rigs(stage, suite, mapping, search_box(envelope, sweeps),
                                             request.known_jumps.get(), progress);
    std::vector<Sweep> all = sweeps;
    all.insert(all.end(), searches.around.begin(), searches.around.end());
    for (std::size_t i = 0; i < suite.rigs.size(); ++i) {
      const RigPlan& plan = suite.rigs[i];
      if (plan.role == Role::canary) {
        if (mapping == plan.duty->mapping)
          report.canaries.push_back(run_canary(plan, sweeps, by_the_table));
        continue;
      }
      records.push_back(plan_rig(stage, body, plan, mapping, all, envelope));
      records.back().search = searches.rig[i];
      if (mapping == suite.mappings.front())
        say_what_is_left_out(records.back(), report.characters.back().notes);
      if (const ExternalRig* external = external_rig(*records.back().system);
          external && mapping == suite.mappings.front())
        for (const std::string& note : external->notes())
          report.characters.back().notes.push_back(note);
    }
  }
  std::size_t poses = 0, looked_at = 0;
  for (const RigRecord& record : records)
    for (const SweepRecord& sweep : record.sweeps) {
      poses += sweep.poses.size();
      // The image pass looks at most poses once more.
      if (request.image_pass && sweep.sweep.watched) looked_at += sweep.poses.size();
    }
  const bool hunts = suite.hunt.percent > 0.0 || suite.hunt.samples > 0;
  progress.start("poses", hunts ? poses : poses + looked_at);
  // Covers the character's file and its sidecar.
  const std::string content = report.characters.back().hash;
  if (!measure_records(stage, body, content, records, ledger, progress, request.known_jumps.get()))
    return run;
  const auto context_of = [&](const RigRecord& record) -> const JudgeContext& {
    return is_external(record.plan.spec) ? external_context : own_context;
  };
  if (!hunt_rigs({stage, body, content, sweeps, context_of}, suite.hunt, records, ledger, progress))
    return run;
  if (hunts && looked_at > 0) progress.start("small pictures", looked_at);

  const render::Bounds box = run.box = framing_of(stage, records);
  PhotographerPool cameras(stage, box);
  ImagePass pictures(cameras, content, ledger);
  const PlaceNames places(stage.character(), stage.anatomy(), &body);
  std::vector<std::vector<Finding>> findings(records.size()), contradictions;
  std::vector<ExternalJudgement> external(records.size());
  std::vector<DeformerJudgement> deformers(records.size());
  const auto judge = [&](std::size_t i) {
    RigRecord& record = records[i];
    judge_samples(stage, body, judges_weights, context_of(record), record);
    findings[i] = judge_rig(record, context_of(record));
    drop_repeats(record, findings[i]);
    book_owners(stage, body, record, judges_weights, findings[i]);
    external[i] = judge_external(record, context_of(record));
    findings[i].insert(findings[i].begin(), external[i].findings.begin(),
                       external[i].findings.end());
    deformers[i] = judge_deformers(record, context_of(record));
    findings[i].insert(findings[i].begin(), deformers[i].findings.begin(),
                       deformers[i].findings.end());
    // What a rig of the studio's does is for its rigger, not for who wrote ours.
    if (is_external(record.plan.spec))
      for (Finding& finding : findings[i])
        if (finding.owner == Owner::solver) finding.owner = Owner::rig;
    name_places(stage, places, record, findings[i]);
    say_to_artist(confirmed.sidecar, record, findings[i]);
    offer_tune(record, stage.rest_chain(), request.chain, run.words, findings[i]);
  };
  // A studio's own rig may remember what it was asked before: those are asked in their order.
  for_each_side_by_side(records.size(), [&](std::size_t i) {
    if (!is_external(records[i].plan.spec)) judge(i);
  });
  for (std::size_t i = 0; i < records.size(); ++i)
    if (is_external(records[i].plan.spec)) judge(i);
  std::map<std::pair<std::string, solver::Mapping>, std::vector<Headroom>> known;
  const auto headroom_in_run = [&](const std::string& system, solver::Mapping mapping) {
    const auto [place, is_new] = known.try_emplace({system, mapping});
    if (!is_new) return place->second;
    for (std::size_t i = 0; i < records.size(); ++i)
      if (records[i].plan.spec.system == system && records[i].plan.spec.options.empty() &&
          records[i].mapping == mapping)
        return place->second = headroom_of(records[i], own_context, findings[i]);
    try {
      place->second = headroom_under(system, body, mapping, sweeps, judges_weights, own_context);
    } catch (const solver::RigError&) {  // this chain has no such system
    }
    return place->second;
  };
  std::vector<std::vector<RigHeadroom>> beside(records.size());
  for (std::size_t i = 0; i < records.size(); ++i)
    for (const std::string& system : systems_beside(records[i].plan)) {
      const auto headroom = headroom_in_run(system, records[i].mapping);
      if (headroom.empty()) continue;
      beside[i].push_back({system, headroom});
      if (system == "even") offer_even(request.chain, run.words, headroom, findings[i]);
    }
  if (request.image_pass) pictures.look(records, findings, progress);
  for (std::size_t i = 0; i < records.size(); ++i) {
    const JudgeContext& context = context_of(records[i]);
    if (deformers[i].measured) {
      const std::string note = blending_note(records[i], deformers[i].blending, stage, places);
      report.characters.back().notes.push_back(note);
      report.reasons.push_back(note);
    }
    if (std::string note = resolution_note(records[i]); !note.empty())
      report.characters.back().notes.push_back(std::move(note));
    report.rigs.push_back(result_of(records[i], context, findings[i]));
    report.rigs.back().beside = std::move(beside[i]);
    take_external(external[i], report.rigs.back());
    for (const Coverage& each : deformers[i].coverage) report.rigs.back().coverage.push_back(each);
    cut_headroom(records[i], deformers[i].findings, report.rigs.back().headroom);
    if (!request.image_pass) continue;
    pictures.add_series(records[i], report.rigs.back());
    contradictions.push_back(pictures.contradictions(records[i], findings[i], context));
    report.rigs.back().coverage.push_back(agreement_coverage(records[i], findings[i]));
  }
  if (suite.pictures.enabled) {
    make_evidence(cameras, body, places, suite.pictures, records, findings, folder, ledger,
                  progress, report);
  }
  const std::size_t before = report.findings.size();
  // Contradictions last, because pictures refer to findings by index.
  for (std::vector<std::vector<Finding>>* const of_rigs : {&findings, &contradictions}) {
    std::ptrdiff_t rig = std::ssize(report.rigs) - std::ssize(records);
    for (std::vector<Finding>& each : *of_rigs) add_findings(std::move(each), rig++, report);
  }
  const std::size_t judged = report.findings.size();
  if (input) judge_file(suite, records, own_context, input->get(), body, report);
  for (std::size_t i = judged; i < report.findings.size(); ++i) places.name({}, report.findings[i]);
  offer_repair(file, run.words, request.chain, std::span(report.findings).subspan(before));
  return run;
}

/// The rigs of the second character, proposed, against those of the first.
std::vector<Comparison> compare_characters(const Report& report, std::vector<CharacterRun>& runs) {
  std::vector<Comparison> comparisons;
  const std::size_t count = runs.front().records.size();
  for (std::size_t i = 0; i < count; ++i) {
    const RigResult &before = report.rigs[i], &now = report.rigs[count + i];
    const auto [before_label, label] = side_labels(runs.front().character, runs.back().character);
    comparisons.push_back(compare_results(now, before, label, before_label));
    comparisons.back().character = "rig " + now.rig;
    comparisons.back().matched =
        surface_match(runs.front().stage->rest().position, runs.back().stage->rest().position);
  }
  return comparisons;
}

/// The comparison, with its worst poses rendered.
void compare(const RunRequest& request, const OutputFolder& folder, std::vector<CharacterRun>& runs,
             Progress& progress, Report& report) {
  if (request.compare == RunRequest::Compare::characters) {
    report.comparisons = compare_characters(report, runs);
    render::Bounds box = runs.front().box;
    box.add(runs.back().box);
    for (std::size_t i = 0; i < report.comparisons.size(); ++i) {
      const auto side = [&](const CharacterRun& run) {
        return ComparedSide{*run.stage, run.records[i], run.words};
      };
      show_worst(report.comparisons[i], side(runs.back()), side(runs.front()), box,
                 request.suite.pictures, folder, progress);
    }
    return;
  }
  report.comparisons = compare_with_references(report);
  if (request.compare == RunRequest::Compare::none) return;
  const CharacterRun& run = runs.front();
  const auto side = [&](Role role) {
    const auto record = std::find_if(run.records.begin(), run.records.end(),
                                     [&](const RigRecord& each) { return each.plan.role == role; });
    return ComparedSide{*run.stage, *record, run.words};
  };
  show_worst(report.comparisons.front(), side(Role::proposed), side(Role::reference), run.box,
             request.suite.pictures, folder, progress);
}

/// The first of two characters that are compared is measured and shown, and does not decide.
Suite as_reference(Suite suite) {
  for (RigPlan& rig : suite.rigs)
    if (rig.role == Role::proposed) rig.role = Role::reference;
  return suite;
}

/// Plants faults of rising size in chains and a round body, and reports what the detectors found.
/// `backbend calibrate` does the same on characters.
void try_detectors(const CalibrationSlice& slice, Progress& progress, Report& report) {
  CalibrationPlan plan;
  plan.clean_poses = static_cast<std::size_t>(slice.poses);
  plan.fault_poses = static_cast<std::size_t>(slice.faults);
  plan.chain_bones = {10, 24};
  const std::unique_ptr<CalibrationBody> tube = tube_body(24);
  const CalibrationBody* bodies[] = {tube.get()};
  CalibrationWatch watch;
  watch.on_stage = [&](const std::string& stage, std::size_t steps) {
    progress.start("calibration, " + stage, steps);
  };
  watch.on_step = [&] {
    poll_interrupt();
    progress.step();
  };
  const CalibrationReport found = calibrate(plan, bodies, watch);
  int clean = 0, alarms = 0;
  std::string missed;
  for (const Sensitivity& s : found.detectors) {
    const Agreement agreement = s.agreement();
    report.calibration.push_back({s.detector, s.code, s.body, s.unit, s.threshold, s.threshold_unit,
                                  static_cast<int>(s.clean), static_cast<int>(s.false_alarms),
                                  s.target, s.smallest, s.ok(), static_cast<int>(agreement.cases()),
                                  static_cast<int>(agreement.alike())});
    clean += static_cast<int>(s.clean);
    alarms += static_cast<int>(s.false_alarms);
    if (!s.ok()) missed += (missed.empty() ? "" : ", ") + s.detector + " on " + s.body;
  }
  report.detectors.push_back(
      std::to_string(found.detectors.size()) + " tried with planted faults: " +
      (missed.empty() ? "each found its target" : "NOT at their target: " + missed) + ", " +
      std::to_string(alarms) + " of " + std::to_string(clean) + " clean poses flagged");
  if (!missed.empty()) report.reasons.push_back("a detector missed its target: " + missed);
  const Agreement agreement = found.agreement();
  report.detectors.push_back("pictures and geometry, each without the other: alike in " +
                             std::to_string(agreement.alike()) + " of " +
                             std::to_string(agreement.cases()) + " clean and faulted cases, " +
                             std::to_string(agreement.geometry_only) + " seen by geometry only, " +
                             std::to_string(agreement.picture_only) + " by pictures only");
}

/// Marks waived findings, and reports waivers that have expired or match nothing.
void waive(const RunRequest& request, Report& report) {
  const std::vector<Waiver>& waivers = request.suite.rules.waivers;
  // Without today's date no waiver can be known to hold.
  const std::string today = request.today.empty() ? "9999-12-31" : request.today;
  const WaiverUse use = apply_waivers(report.findings, waivers, today);
  const auto name = [&](std::size_t i) {
    return "the waiver of " + waivers[i].code + " (" + waivers[i].owner + ": " + waivers[i].reason +
           ")";
  };
  for (const std::size_t i : use.holding) {
    const int days = days_between(today, waivers[i].expires);
    report.reasons.push_back(name(i) + " holds until " + waivers[i].expires + ", " +
                             std::to_string(days) + (days == 1 ? " day" : " days") + " left");
  }
  for (const std::size_t i : use.expired)
    report.reasons.push_back(name(i) + " expired on " + waivers[i].expires +
                             ": its findings fail again");
  for (const std::size_t i : use.unused)
    report.reasons.push_back(name(i) + " matches no finding; remove it");
}

/// Meshes are in the folders of their findings' pictures.
void link_meshes(Report& report) {
  for (MeshView& mesh : report.meshes) {
    const std::string place = mesh.pose_path.substr(0, mesh.pose_path.rfind('/') + 1);
    for (std::size_t i = 0; i < report.findings.size() && mesh.finding < 0; ++i)
      if (report.findings[i].pictures.before.starts_with(place)) mesh.finding = static_cast<int>(i);
  }
}

/// Files of the report by their paths, where those stay in the folder.
PictureBytes files_in(const std::filesystem::path& folder) {
  return [folder](const std::string& name) -> std::optional<std::vector<std::uint8_t>> {
    const std::filesystem::path path(name);
    if (path.is_absolute() || std::find(path.begin(), path.end(), "..") != path.end())
      return std::nullopt;
    std::error_code none;
    if (!std::filesystem::is_regular_file(folder / path, none)) return std::nullopt;
    return read_bytes(folder / path);
  };
}

}  // namespace

std::string RunRequest::character_text(const std::filesystem::path& file) const {
  if (!character.empty()) return character;
  if (suite.file.empty()) return file.string();
  const std::filesystem::path folder =
      std::filesystem::absolute(suite.file).lexically_normal().parent_path();
  // A project keeps its suites in `scenes`, and its commands are run from the folder above.
  return file.lexically_proximate(folder.filename() == "scenes" ? folder.parent_path() : folder)
      .string();
}

std::string RunRequest::character_words(const std::filesystem::path& file) const {
  std::string words = shell_word(character_text(file));
  const auto add = [&](const char* option, const std::vector<std::string>& joints) {
    std::string list;
    for (const std::string& joint : joints) list += (list.empty() ? "" : ",") + joint;
    if (!list.empty()) words += " " + std::string(option) + " " + shell_word(list);
  };
  add("--template", {hints.rig_template});
  add("--hip", {hints.hip});
  add("--chest", {hints.chest});
  add("--spine", hints.spine);
  add("--left-arm", hints.left_arm);
  add("--right-arm", hints.right_arm);
  add("--up", {hints.up});
  add("--forward", {hints.forward});
  return words;
}

namespace {

/// How many days planted faults count: a broken detector must not hide for a week.
constexpr int kCalibrationDays = 5;

/// The lists of a report that a unit of work adds to.
template <class Reports, class Do>
void each_list(Reports& a, const Do& act) {
  act(a.characters, &Report::characters);
  act(a.rigs, &Report::rigs);
  act(a.findings, &Report::findings);
  act(a.canaries, &Report::canaries);
  act(a.pairs, &Report::pairs);
  act(a.media, &Report::media);
  act(a.meshes, &Report::meshes);
  act(a.detectors, &Report::detectors);
  act(a.calibration, &Report::calibration);
  act(a.reasons, &Report::reasons);
}

/// What a report has gained since it was as long as `before` says, in the order of each_list().
std::vector<std::size_t> lengths_of(const Report& report) {
  std::vector<std::size_t> lengths;
  each_list(report, [&](const auto& list, auto) { lengths.push_back(list.size()); });
  return lengths;
}

Report gained(const Report& report, const std::vector<std::size_t>& before) {
  Report part;
  auto length = before.begin();
  each_list(report, [&](const auto& list, auto member) {
    (part.*member).assign(list.begin() + static_cast<std::ptrdiff_t>(*length++), list.end());
  });
  const int rigs = static_cast<int>(report.rigs.size() - part.rigs.size());
  for (Finding& finding : part.findings) finding.at.rig -= finding.at.rig < 0 ? 0 : rigs;
  return part;
}

void append(Report& report, const Report& part) {
  const std::size_t findings = report.findings.size();
  const int rigs = static_cast<int>(report.rigs.size());
  each_list(part, [&](const auto& list, auto member) {
    (report.*member).insert((report.*member).end(), list.begin(), list.end());
  });
  for (Finding& finding : std::span(report.findings).subspan(findings))
    finding.at.rig += finding.at.rig < 0 ? 0 : rigs;
}

/// Takes back what a report has gained since it was as long as `before` says.
void shorten(Report& report, const std::vector<std::size_t>& before) {
  auto length = before.begin();
  each_list(report, [&](auto& list, auto) {
    list.erase(list.begin() + static_cast<std::ptrdiff_t>(*length++), list.end());
  });
}

/// A rig of the studio's own that was not measured on the report's last character: it is in the
/// report, never clean.
void report_unavailable(const RigPlan& plan, const std::vector<solver::Mapping>& mappings,
                        const RigUnavailable& why, Report& report) {
  for (const solver::Mapping mapping : mappings) {
    RigResult result;
    result.character = report.characters.back().name;
    result.rig = plan.name;
    result.system = plan.spec.system;
    result.mapping = mapping_name(mapping);
    result.role = plan.role;
    Finding finding;
    finding.code = "BB052";
    finding.at.rig = static_cast<int>(report.rigs.size());
    finding.character = result.character;
    finding.rig = result.rig;
    finding.mapping = result.mapping;
    finding.pose = "none";
    finding.unit = find_check(finding.code)->unit;
    finding.verdict = Verdict::not_measured;
    // What cannot even be started is bad input, as a character that cannot be read.
    finding.owner = why.started ? Owner::rig : Owner::input;
    finding.detail = why.what();
    report.rigs.push_back(std::move(result));
    report.findings.push_back(std::move(finding));
  }
}

/// A character with every rig of the suite that answers. Where the program of one gives up, all
/// that was measured of this character is taken back and measured again without that rig: which
/// poses are looked at depends on the rigs that are compared. Throws RigUnavailable where nothing
/// else is to be measured. `complete`: whether every rig answered.
CharacterRun run_with_answers(const RunRequest& request, Suite suite,
                              const std::filesystem::path& file, const OutputFolder& folder,
                              Ledger& ledger, Progress& progress, Report& report, bool& complete) {
  const std::vector<std::size_t> before = lengths_of(report);
  std::vector<std::pair<RigPlan, RigUnavailable>> left_out;
  RunRequest asked = request;
  while (true) {
    try {
      CharacterRun run = run_character(asked, suite, file, folder, ledger, progress, report);
      for (const auto& [plan, why] : left_out)
        report_unavailable(plan, suite.mappings, why, report);
      complete = left_out.empty();
      return run;
    } catch (const RigUnavailable& why) {
      const auto gone = std::ranges::find_if(suite.rigs, [&](const RigPlan& plan) {
        return is_external(plan.spec) && external_key(plan.spec) == why.rig;
      });
      const auto others = std::ranges::count_if(
          suite.rigs, [](const RigPlan& plan) { return plan.role != Role::canary; });
      if (request.compare != RunRequest::Compare::none || gone == suite.rigs.end() ||
          (others == 1 && request.suite.characters.size() == 1))
        throw;
      progress.say(std::string("backbend: ") + why.what() +
                   "; not measured, the others go on without it");
      left_out.emplace_back(*gone, why);
      suite.rigs.erase(gone);
      shorten(report, before);
      asked.on_character = nullptr;  // it has been announced
    }
  }
}

std::string carried_note(const std::string& night) {
  return "carried over from the night " + night + ": the same inputs, options and program";
}

/// One unit of work: an earlier night's result where that holds, else `work`, and either noted for
/// the nights to come. `fits`: whether the report can take a result; `work` returns whether another
/// night could take what it adds. Without a `stamp` nothing is taken or noted.
class Carried {
 public:
  Carried(const RunRequest& request, Progress& progress, Report& report)
      : carry_(request.compare == RunRequest::Compare::none ? request.carry.get() : nullptr),
        folder_(request.folder),
        progress_(progress),
        report_(report) {}

  /// Returns the night that the result is from; empty: it was measured now.
  template <class Fits, class Work>
  std::string take_or_do(const std::string& unit, const std::string& stamp, int most_days,
                         const Fits& fits, const Work& work) {
    if (carry_ == nullptr || stamp.empty()) {
      work();
      return "";
    }
    auto found = carry_->find(unit, stamp, folder_, most_days, fits,
                              [&](const std::string& why) { progress_.say("backbend: " + why); });
    if (found) {
      append(report_, found->report);
      const std::string night = found->night;
      carry_->note(unit, stamp, std::move(*found));
      return night;
    }
    const FolderListing before = list_results(folder_);
    const std::vector<std::size_t> lengths = lengths_of(report_);
    if (work())
      carry_->note(unit, stamp,
                   {gained(report_, lengths),
                    carry_->tonight(),
                    files_made(before, list_results(folder_)),
                    {}});
    return "";
  }

  CarryOver* store() const { return carry_; }

 private:
  CarryOver* carry_;
  std::filesystem::path folder_;
  Progress& progress_;
  Report& report_;
};

/// A character as a unit of work, and its stamp, which is empty where it cannot be read.
std::pair<std::string, std::string> carried_unit(const RunRequest& request, const CarryOver& store,
                                                 const std::filesystem::path& file) {
  std::string stamp;
  try {
    stamp = content_hash(store.place().inputs + " " + character_content(file) + " " +
                         request.character_words(file));
  } catch (const ReadError&) {
    // Reading it says why, as an entry of the report.
  }
  return {"character " + request.character_text(file) + " of " + request.suite.name, stamp};
}

/// Reads what earlier nights left of all characters before the first is looked at.
void read_carried_ahead(const RunRequest& request, CarryOver& store) {
  const std::vector<std::filesystem::path>& files = request.suite.characters;
  std::vector<std::pair<std::string, std::string>> units(files.size());
  for_each_side_by_side(files.size(),
                        [&](std::size_t i) { units[i] = carried_unit(request, store, files[i]); });
  store.read_ahead(units);
}

}  // namespace

Report run_suite(const RunRequest& request, Progress& progress) {
  const Suite& suite = request.suite;
  Report report;
  report.title = request.title.empty() ? suite.title : request.title;
  report.suite = suite.name;
  if (!suite.file.empty()) report.provenance["suite"] = content_hash(read_bytes(suite.file));
  LimitSet limits = limits_for(suite.rules, "");
  if (std::ranges::all_of(suite.rigs, [](const RigPlan& rig) {
        return rig.role == Role::canary || is_external(rig.spec);
      }))
    limits = external_limits(limits);
  const OutputFolder folder(request.folder);
  const auto ledger = request.ledger ? request.ledger : std::make_shared<Ledger>();

  const bool comparing = request.compare != RunRequest::Compare::none;
  report.is_comparison = comparing;
  std::vector<CharacterRun> runs;  // of a comparison
  Carried carried(request, progress, report);
  std::size_t carried_count = 0;
  std::vector<std::filesystem::path> doubtful;
  if (carried.store() != nullptr && !carried.store()->place().fresh)
    read_carried_ahead(request, *carried.store());
  for (const std::filesystem::path& file : suite.characters) {
    poll_interrupt();
    try {
      const bool reference = request.compare == RunRequest::Compare::characters && runs.empty();
      const auto measure = [&] {
        bool complete = true;
        CharacterRun run = run_with_answers(request, reference ? as_reference(suite) : suite, file,
                                            folder, *ledger, progress, report, complete);
        const bool numbered = run.numbered;
        if (comparing) runs.push_back(std::move(run));
        return complete && !numbered;
      };
      const auto fits = [&](const Report& part) {
        return part.characters.size() == 1 &&
               std::ranges::find(report.characters, part.characters.front().name,
                                 &CharacterFacts::name) == report.characters.end();
      };
      // Asked for again: a file may have been saved since the night began.
      const auto [unit, stamp] = carried.store() == nullptr
                                     ? std::pair<std::string, std::string>()
                                     : carried_unit(request, *carried.store(), file);
      const std::string night = carried.take_or_do(unit, stamp, 0, fits, measure);
      if (!report.characters.back().doubts.empty()) doubtful.push_back(file);
      if (night.empty()) continue;
      ++carried_count;
      CharacterFacts& facts = report.characters.back();
      if (request.on_character) request.on_character(facts);
      facts.notes.push_back(carried_note(night));
      report.provenance["carried " + facts.name] = night;
    } catch (const skin::CharacterError& error) {
      // Nothing else to run, or to compare with: the error ends the run.
      if (suite.characters.size() == 1 || comparing) throw;
      report.findings.push_back(input_finding(file, error.what()));
      progress.say(std::string("backbend: ") + error.what());
    }
  }
  // Shard reports are partial.
  if (suite.calibration.poses > 0 && ledger->assembles()) {
    const std::string slice = std::to_string(suite.calibration.poses) + " poses, " +
                              std::to_string(suite.calibration.faults) + " faults";
    const std::string night = carried.take_or_do(
        "planted faults", carried.store() == nullptr ? "" : slice + " " + program_inputs(),
        kCalibrationDays, [](const Report&) { return true; },
        [&] {
          try_detectors(suite.calibration, progress, report);
          return true;
        });
    if (!night.empty()) {
      report.detectors.push_back("planted faults are " + carried_note(night));
      report.provenance["carried planted faults"] = night;
    }
  }
  if (carried_count > 0)
    report.reasons.push_back(std::to_string(carried_count) + " of " +
                             std::to_string(suite.characters.size()) +
                             " characters carried over from earlier nights, for nothing that they "
                             "depend on has changed");
  if (!request.calibrated.empty()) report.detectors.push_back(request.calibrated);
  if (request.image_pass) report.detectors.push_back(agreement_line(report.findings));
  progress.finish();
  if (const std::vector<std::string> missing = ledger->missing(); !missing.empty()) {
    throw IncompleteError(request.folder.string() + ": " + std::to_string(missing.size()) +
                          " parts of the job are missing");
  }
  // Versions need the library of pictures: PicturesAhead has loaded it by now, and a run that was
  // refused did without.
  report.provenance.merge(program_versions());
  for (const CharacterFacts& facts : report.characters)
    report.provenance["character " + facts.name] = facts.hash;
  std::stable_partition(
      report.findings.begin(), report.findings.end(), [&](const Finding& finding) {
        return std::any_of(suite.rigs.begin(), suite.rigs.end(), [&](const RigPlan& rig) {
          return rig.name == finding.rig && rig.role == Role::proposed;
        });
      });
  compare(request, folder, runs, progress, report);
  waive(request, report);
  report.checks = legend(report, limits);
  if (!report.findings.empty()) {
    report.next = {"backbend explain " + report.findings.front().code};
    if (!report.findings.front().reproduce.empty())
      report.next.push_back(report.findings.front().reproduce);
    const auto repairable = std::ranges::find_if(
        report.findings, [](const Finding& each) { return !each.cures.empty(); });
    if (repairable != report.findings.end())
      report.next.push_back(repairable->cures.front().command);
  }
  for (const std::filesystem::path& file : doubtful)
    report.next.insert(report.next.begin(), confirm_command(file));
  if (request.baseline) {
    const Digest digest(report);
    apply_baseline(
        report.findings, [&](const Finding& finding) { return digest.role_of(finding); },
        *request.baseline, request.today);
    report.provenance["baseline"] = content_hash(baseline_json(*request.baseline));
  }
  link_meshes(report);
  conclude(report);
  if (request.history) {
    std::vector<Night> nights = *request.history;
    nights.push_back(night_of(report, request.today, request.label, ""));  // not whole yet
    if (std::string news = news_of(nights); !news.empty())
      report.reasons.push_back(std::move(news));
    TrendTable table = trends_of(nights, report.suite);
    report.nights = std::move(table.nights);
    report.trends = std::move(table.trends);
  }
  return report;
}

void write_report(const Report& report, const std::filesystem::path& path, const PageStyle& style) {
  const OutputFolder folder(path);
  const PictureBytes files = files_in(style.files.empty() ? path : style.files);
  const std::string json = report_json(report);
  const std::string hash = content_hash(json);
  folder.write("report.json", json);
  const auto write = [&](const char* name, const std::string& text) {
    if (!text.empty()) folder.write(name, text);
  };
  // What takes longest comes first.
  const std::function<void()> pieces[] = {
      [&] {
        if (style.single_file) {
          folder.write("index.html", render_html_page(report, files, hash));
        } else {
          for (const auto& [name, text] : render_html(report, files, hash))
            folder.write(name, text);
        }
      },
      [&] { write("sweeps.csv", sweeps_csv(report)); },
      [&] { write("findings.csv", findings_csv(report)); },
      [&] { write("junit.xml", junit_xml(report)); },
      [&] { write("report.md", markdown_summary(report)); },
      [&] {
        write("headline.txt", headline_text(report));
        folder.write("headline.png", headline_png(report, files));
      },
      [&] { write("review/angles.csv", angles_csv(report)); },
      [&] { write("review/sweeps.otio", sweeps_otio(report)); },
      [&] { write("review/findings.otio", findings_otio(report)); }};
  for_each_side_by_side(std::size(pieces), [&](std::size_t i) { pieces[i](); });
}

}  // namespace backbend::validate
