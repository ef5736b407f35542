#include "validate/why/recorded_run.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "validate/files/hash.h"
#include "validate/files/output_folder.h"
#include "validate/judge/confirmed.h"
#include "validate/measure/compound_search.h"
#include "validate/model/report_json.h"
#include "validate/night/run.h"
#include "validate/sweeps/external_spec.h"
#include "validate/text/joined.h"
#include "validate/text/number_text.h"

namespace backbend::validate {
namespace {

namespace fs = std::filesystem;

fs::path report_of(const std::string& text) {
  const fs::path path(text);
  return fs::is_directory(path) ? path / "report.json" : path;
}

const CharacterFacts& character_of(const Report& report, const std::string& text,
                                   const std::string& wanted) {
  const std::string name = fs::path(wanted).filename().string();
  const auto& all = report.characters;
  const auto found = std::ranges::find_if(all, [&](const CharacterFacts& each) {
    return name.empty() || each.file == name || each.name == name;
  });
  if (found == all.end())
    throw skin::CharacterError(text + (name.empty() ? ": a run of no character"
                                                    : ": no character '" + name + "' in this run"));
  if (name.empty() && all.size() > 1)
    throw skin::CharacterError(text + ": a run of " + std::to_string(all.size()) +
                               " characters; --character NAME says which, for example " +
                               all.front().file);
  return *found;
}

const RigResult& rig_of(const Report& report, const CharacterFacts& facts, const std::string& text,
                        const std::string& rig) {
  const auto found = std::ranges::find_if(report.rigs, [&](const RigResult& each) {
    return each.character == facts.name &&
           (rig.empty() ? each.role == Role::proposed : each.rig == rig);
  });
  if (found == report.rigs.end())
    throw skin::CharacterError(text + (rig.empty() ? ": no proposed rig in this run"
                                                   : ": no rig '" + rig + "' in this run"));
  if (found->system == kExternal)
    throw skin::CharacterError(text + ": rig '" + found->rig +
                               "' is a rig of your own; its program is not in the run's folder");
  return *found;
}

RigPlan plan_of(const RigResult& result) {
  std::string text = result.system;
  for (const auto& [key, value] : result.options)
    text += (text.size() == result.system.size() ? ":" : ",") + key + "=" + value;
  RigPlan plan = read_rig(text);
  plan.name = result.rig;
  return plan;
}

/// Whether a run measured the poses that `check` measures under this name.
bool is_swept_alike(const RigResult& result, const Sweep& sweep) {
  constexpr double kSame_deg = 1e-6;
  const auto found = std::ranges::find(result.sweeps, sweep.name, &SweepSeries::sweep);
  if (found == result.sweeps.end() || found->control_deg.size() != sweep.pose_count()) return false;
  for (std::size_t i = 0; i < sweep.pose_count(); ++i) {
    if (std::abs(found->control_deg[i] - sweep.control_at(i)) > kSame_deg) return false;
    const PoseDegrees pose = sweep.pose_at(sweep.control_at(i));
    for (const auto& [channel, degrees] : found->pose_deg)
      if (const double* own = pose.find(channel); !own || std::abs(degrees[i] - *own) > kSame_deg)
        return false;
  }
  return true;
}

/// A waived failure is one still. Those of the file do not decide in every suite.
bool is_failure(const Finding& finding) {
  return finding.verdict == Verdict::fail || finding.verdict == Verdict::waived ||
         (finding.verdict == Verdict::stress && finding.sweep.empty());
}

bool is_character(const fs::path& file) {
  const std::string kind = file.extension().string();
  return kind == ".glb" || kind == ".gltf" || kind == ".fbx" || kind == ".dae";
}

/// With the spine that the run judged.
void expect_spine(const RecordedRun& run, const Version& version, DrivenChain chain) {
  const Stage stage(version.character, version.hints, chain);
  const std::vector<std::string> spine =
      facts_of(stage.character(), stage.anatomy(), run.envelope).spine;
  if (spine != run.spine)
    throw skin::CharacterError(
        version.label + ": its spine is now " + joined(spine) + ", and was " + joined(run.spine) +
        " in the run; --hip, --chest, --spine, --chain and the sidecar have to say what they said");
}

}  // namespace

bool is_recorded_run(const std::string& text) {
  std::error_code none;
  return fs::is_directory(text, none) || fs::path(text).filename() == "report.json";
}

RecordedRun read_recorded_run(const std::string& text, const RecordedChoice& choice) {
  const fs::path file = report_of(text);
  const Report report = parse_report(read_text(file), file.string());
  const CharacterFacts& facts = character_of(report, text, choice.character);
  const RigResult& result = rig_of(report, facts, text, choice.rig);
  const auto envelope = find_envelope(facts.envelope);
  const auto mapping = find_mapping(result.mapping);
  if (!envelope || !mapping)
    throw skin::CharacterError(
        text + ": this version of backbend has no " +
        (envelope ? "mapping '" + result.mapping : "envelope '" + facts.envelope) + "'");
  RecordedRun out;
  out.character = facts.file;
  out.hash = facts.hash;
  out.spine = facts.spine;
  out.rig = plan_of(result);
  out.mapping = *mapping;
  out.envelope = facts.envelope;
  for (const CheckLegend& row : report.checks)
    if (const Check* check = find_check(row.code);
        check && std::isfinite(row.limit) && check->limit != row.limit)
      out.limits[row.code] = row.limit;
  for (const auto& [name, version] : report.provenance)
    if (name == "backbend" || name == "compiler" || name.starts_with("library "))
      out.program[name] = version;
  Suite suite;
  suite.standard = suite.corners = true;
  std::set<std::string> sweeps{""};
  for (const Sweep& sweep : sweeps_for(suite, *envelope))
    if (is_swept_alike(result, sweep)) sweeps.insert(sweep.name);
  for (const Finding& finding : report.findings) {
    if (finding.character != facts.name || !is_failure(finding) || !find_check(finding.code))
      continue;
    const bool of_rig = finding.at.rig == &result - report.rigs.data();
    if (!of_rig && !finding.rig.empty()) continue;
    if (sweeps.contains(finding.sweep) || finding.sweep.starts_with(kJumpSweep))
      add_failure(finding, out.failures);
    else
      ++out.other_sweeps;
  }
  return out;
}

Version version_of(const RecordedRun& run, const fs::path& folder, const skin::AnatomyHints& hints,
                   DrivenChain chain) {
  std::vector<fs::path> files;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(folder.empty() ? "." : folder, none))
    if (is_character(entry.path()))
      files.push_back(folder.empty() ? entry.path().filename() : entry.path());
  std::ranges::sort(files);
  std::ranges::stable_partition(
      files, [&](const fs::path& file) { return file.filename() == run.character; });
  for (const fs::path& file : files) {
    std::optional<Version> version;
    try {
      version = load_version(file.string(), hints, run.rig);
    } catch (const skin::CharacterError&) {
      continue;  // another file, and none of ours
    }
    const skin::Character& body = version->character;
    if (hash_text(body.content_hash_high, body.content_hash_low) != run.hash) continue;
    expect_spine(run, *version, chain);
    return std::move(*version);
  }
  throw skin::CharacterError("'" + run.character + "' as it was measured (content " + run.hash +
                             ") is not in " + (folder.empty() ? "." : folder.string()) +
                             "; --characters names the folder that holds it");
}

std::string unlike(const RecordedRun& a, const RecordedRun& b) {
  if (a.mapping != b.mapping)
    return std::string("mapping ") + std::string(mapping_name(a.mapping)) + " and " +
           std::string(mapping_name(b.mapping));
  if (a.envelope != b.envelope) return "envelope " + a.envelope + " and " + b.envelope;
  std::set<std::string> codes;
  for (const RecordedRun* run : {&a, &b})
    for (const auto& [code, limit] : run->limits) codes.insert(code);
  for (const std::string& code : codes) {
    const auto limit_in = [&](const RecordedRun& run) {
      const auto found = run.limits.find(code);
      return found == run.limits.end() ? find_check(code)->limit : found->second;
    };
    if (limit_in(a) != limit_in(b))
      return "limit " + number_text(limit_in(a)) + " and " + number_text(limit_in(b)) + " of " +
             code;
  }
  return {};
}

std::string program_difference(const std::map<std::string, std::string>& before,
                               const std::map<std::string, std::string>& after) {
  std::set<std::string> names;
  for (const auto* each : {&before, &after})
    for (const auto& [name, version] : *each) names.insert(name);
  const auto version_in = [](const std::map<std::string, std::string>& program,
                             const std::string& name) {
    const auto found = program.find(name);
    return found == program.end() ? std::string("none") : found->second;
  };
  std::string text;
  for (const std::string& name : names) {
    const std::string was = version_in(before, name), is = version_in(after, name);
    if (was != is) text += (text.empty() ? "" : ", ") + name + " " + was + " -> " + is;
  }
  return text;
}

}  // namespace backbend::validate
