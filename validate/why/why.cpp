#include "validate/why/why.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <set>

#include "skin/anatomy/body_kind.h"
#include "validate/judge/judge.h"
#include "validate/judge/judge_external.h"
#include "validate/judge/judge_input.h"
#include "validate/judge/owner.h"
#include "validate/judge/place.h"
#include "validate/live/external_rig.h"
#include "validate/measure/compound_search.h"
#include "validate/metrics/surface/weight_hygiene.h"
#include "validate/sweeps/external_spec.h"

namespace backbend::validate {
namespace {

using Index = std::size_t;

// A value that differs by less reads the same in a report.
constexpr double kWorse = 1.001;

std::string key_of(const Finding& finding) {
  return finding.code + (finding.sweep.empty() ? "" : " " + finding.sweep);
}

double badness(const Finding& finding) {
  return excess(*find_check(finding.code), finding.value, finding.limit);
}

double badness_in(const Failures& failures, const std::string& key) {
  const auto found = failures.find(key);
  return found == failures.end() ? 0.0 : badness(found->second);
}

/// Keys that the later one has and the earlier has not, or not so badly.
std::vector<std::string> worse_in(const Failures& before, const Failures& after) {
  std::vector<std::string> keys;
  for (const auto& [key, finding] : after)
    if (badness(finding) > kWorse * badness_in(before, key)) keys.push_back(key);
  return keys;
}

}  // namespace

Failures failures_of(const Version& version, const WhySettings& settings, const std::string& only) {
  const std::vector<skin::SidecarControl> controls =
      version.sidecar ? version.sidecar->controls : std::vector<skin::SidecarControl>();
  const Stage stage(version.character, version.hints, settings.chain, controls);
  const skin::BodyKind kind =
      skin::body_kind(stage.character(), settings.chain == DrivenChain::neck
                                             ? skin::find_anatomy(stage.character(), version.hints)
                                             : stage.anatomy())
          .kind;
  Envelope envelope = envelope_for(kind, settings.chain == DrivenChain::neck);
  if (version.sidecar && !version.sidecar->envelope.empty())
    if (const auto own = find_envelope(version.sidecar->envelope)) envelope = *own;
  if (!settings.envelope.empty()) envelope = *find_envelope(settings.envelope);

  Suite suite;
  suite.standard = suite.corners = true;
  std::vector<Sweep> sweeps = sweeps_for(suite, envelope);
  const std::string sweep = only.size() > 6 ? only.substr(6) : "";  // after `BB011 `
  const bool known = std::ranges::any_of(sweeps, [&](const Sweep& s) { return s.name == sweep; });
  if (only.empty() || (!sweep.empty() && !known)) {
    const auto system = stage.build(version.rig.spec);
    const ExternalRig* external = external_rig(*system);
    if (!external || !external->has_memory())
      for (Sweep& each :
           search_compound(*system, settings.mapping, search_box(envelope, sweeps)).around)
        sweeps.push_back(std::move(each));
  }
  if (!only.empty()) std::erase_if(sweeps, [&](const Sweep& s) { return s.name != sweep; });

  const BodyMetrics body(stage.character(), stage.anatomy(), stage.driver());
  Progress silent(Progress::Style::none);
  const RigRecord rig =
      measure_rig(stage, body, version.rig, settings.mapping, sweeps, envelope, silent);
  LimitSet limits;
  for (const auto& [code, limit] : settings.limits)
    limits.set(code, {limit, LimitLayer::studio, "the run", "the run", "as in the run"});
  if (is_external(version.rig.spec)) limits = external_limits(std::move(limits));
  const JudgeContext context{stage, limits, envelope, version.label};
  std::vector<Finding> findings = judge_rig(rig, context);
  book_owners(stage, body, rig, true, findings);
  if (only.empty() || sweep.empty()) {
    const WeightHygiene weights = examine_weights(stage.character(), stage.character().influences);
    for (Finding& finding : judge_input(rig, context, weights, true).findings)
      findings.push_back(std::move(finding));
  }
  const PlaceNames places(stage.character(), stage.anatomy(), &body);
  Failures out;
  for (Finding& finding : findings) {
    if (finding.verdict != Verdict::fail) continue;
    if (!find_check(finding.code) || !std::isfinite(finding.value)) continue;
    if (is_external(version.rig.spec) && finding.owner == Owner::solver) finding.owner = Owner::rig;
    places.name({}, finding);
    add_failure(std::move(finding), out);
  }
  return out;
}

void add_failure(Finding finding, Failures& failures) {
  const auto [known, is_new] = failures.emplace(key_of(finding), finding);
  if (!is_new && badness(finding) > badness(known->second)) known->second = std::move(finding);
}

namespace {

/// Measures mixtures, each once.
class Mixer {
 public:
  Mixer(const VersionPair& pair, const WhySettings& settings, Progress& progress, WhyPair& out)
      : pair_(pair), settings_(settings), progress_(progress), out_(out) {}

  /// Nullptr: the mixture cannot be measured.
  const Failures* of(IngredientSet set) {
    const auto known = measured_.find(set);
    if (known != measured_.end()) return known->second ? &*known->second : nullptr;
    poll_interrupt();
    std::optional<Failures> failures;
    try {
      failures = failures_of(pair_.mixed(set), settings_);
      ++out_.measured;
    } catch (const skin::CharacterError& error) {
      note(set, error.what());
    } catch (const solver::RigError& error) {
      note(set, error.what());
    }
    progress_.step();
    auto& kept = measured_[set] = std::move(failures);
    return kept ? &*kept : nullptr;
  }

  void take(IngredientSet set, Failures failures) { measured_[set] = std::move(failures); }

  /// How bad one finding is in a mixture of parts; nothing where that cannot be measured.
  std::optional<double> bad_in_parts(IngredientSet set, const VersionPair::Parts& parts,
                                     const std::string& key) {
    // Findings of one sweep share its measurement.
    std::string name = std::to_string(set) + "|" + key.substr(std::min<Index>(5, key.size()));
    for (const auto* names : {&parts.weights, &parts.options})
      if (*names)
        for (const std::string& each : **names) name += "|" + each;
    if (const auto known = in_parts_.find(name); known != in_parts_.end())
      return known->second ? std::optional(badness_in(*known->second, key)) : std::nullopt;
    poll_interrupt();
    std::optional<Failures> failures;
    try {
      failures = failures_of(pair_.mixed(set, parts), settings_, key);
      ++out_.measured;
    } catch (const skin::CharacterError&) {  // then the part is kept
    } catch (const solver::RigError&) {
    }
    const auto& kept = in_parts_[name] = std::move(failures);
    return kept ? std::optional(badness_in(*kept, key)) : std::nullopt;
  }

 private:
  void note(IngredientSet set, const std::string& why) {
    std::string names;
    for (const Ingredient each : members(set))
      names += (names.empty() ? "" : ", ") + std::string(name_of(each));
    out_.unmeasured.push_back("only " + names + " taken over: " + why);
  }

  const VersionPair& pair_;
  const WhySettings& settings_;
  Progress& progress_;
  WhyPair& out_;
  std::map<IngredientSet, std::optional<Failures>> measured_;
  std::map<std::string, std::optional<Failures>> in_parts_;
};

/// Sets of these ingredients, those of fewer first, never empty.
std::vector<IngredientSet> subsets(IngredientSet of) {
  std::vector<IngredientSet> sets;
  for (IngredientSet set = 1; set <= of; ++set)
    if ((set & of) == set) sets.push_back(set);
  std::ranges::stable_sort(sets, {}, [](IngredientSet set) { return std::popcount(set); });
  return sets;
}

/// The names without which a finding is no longer made, one by one put back where it stays.
template <typename Put>
std::vector<std::string> needed(std::vector<std::string> names, const Put& makes_it) {
  for (Index i = names.size(); i-- > 0 && names.size() > 1;) {
    std::vector<std::string> fewer = names;
    fewer.erase(fewer.begin() + static_cast<std::ptrdiff_t>(i));
    if (makes_it(fewer)) names = std::move(fewer);
  }
  return names;
}

/// What the runs say got worse and this program does not see change.
void take_program(const Failures& before, const Failures& after, const RecordedFailures& recorded,
                  WhyPair& out) {
  if (!recorded.before && !recorded.after) return;
  const Failures& was = recorded.before ? *recorded.before : before;
  const Failures& is = recorded.after ? *recorded.after : after;
  const std::vector<std::string> here = worse_in(before, after);
  for (const std::string& key : worse_in(was, is)) {
    if (std::ranges::find(here, key) != here.end()) continue;
    WhyFinding why;
    why.key = key;
    why.finding = is.at(key);
    why.ingredients = bit(Ingredient::program);
    if (const auto found = was.find(key); found != was.end()) why.was = found->second.value;
    if (const auto found = after.find(key); found != after.end()) why.without = found->second.value;
    out.changed |= bit(Ingredient::program);
    out.differences[Ingredient::program] = recorded.programs;
    out.findings.push_back(std::move(why));
  }
}

}  // namespace

WhyPair why(const VersionPair& pair, const WhySettings& settings, Progress& progress,
            const RecordedFailures& recorded) {
  WhyPair out;
  out.before = pair.before().label;
  out.after = pair.after().label;
  out.changed = pair.changed();
  out.coverage = pair.coverage();
  for (const Ingredient each : members(out.changed)) out.differences[each] = pair.difference(each);
  progress.start("versions", 2);
  Mixer mixer(pair, settings, progress, out);
  // The two themselves must be measurable: what keeps them from it is thrown.
  mixer.take(0, failures_of(pair.before(), settings));
  progress.step();
  mixer.take(out.changed, failures_of(pair.after(), settings));
  progress.step();
  out.measured = 2;
  const Failures before = *mixer.of(0), after = *mixer.of(out.changed);
  progress.finish();
  take_program(before, after, recorded, out);
  if (pair.changed() == 0) return out;
  // At most every mixture of the two.
  progress.start("mixtures", (std::size_t{1} << members(pair.changed()).size()) - 2);
  const std::vector<std::string> told = worse_in(recorded.before ? *recorded.before : before,
                                                 recorded.after ? *recorded.after : after);
  for (const std::string& key : worse_in(before, after)) {
    if (std::ranges::find(told, key) == told.end()) continue;
    WhyFinding why;
    why.key = key;
    why.finding = after.at(key);
    const double old_bad = badness_in(before, key), new_bad = badness(why.finding);
    if (const auto found = before.find(key); found != before.end()) why.was = found->second.value;
    // Half of what it got worse by; of a new one half of what it is beyond its limit.
    const double from = std::max(old_bad, 1.0);
    const double half = from + 0.5 * (new_bad - from);
    const auto makes = [&](double bad) { return bad > 0.0 && bad >= half; };
    for (const IngredientSet set : subsets(pair.changed())) {
      const Failures* with = mixer.of(set);
      if (with == nullptr || !makes(badness_in(*with, key))) continue;
      const Failures* without = mixer.of(pair.changed() & ~set);
      if (without == nullptr || makes(badness_in(*without, key))) continue;
      why.ingredients = set;
      if (const auto found = without->find(key); found != without->end())
        why.without = found->second.value;
      break;
    }
    VersionPair::Parts parts;
    const auto still = [&](const VersionPair::Parts& tried) {
      const auto bad = mixer.bad_in_parts(why.ingredients, tried, key);
      return bad && makes(*bad);
    };
    if (why.ingredients & bit(Ingredient::options)) {
      parts.options = why.options = needed(pair.changed_options(), [&](const auto& fewer) {
        VersionPair::Parts tried = parts;
        tried.options = fewer;
        return still(tried);
      });
    }
    if (why.ingredients & bit(Ingredient::weights)) {
      std::vector<std::string> joints;
      for (const auto& [name, vertices] : pair.changed_weights()) joints.push_back(name);
      // Those of few vertices are tried last, and so put back first.
      std::ranges::stable_sort(joints, std::greater<>(), [&](const std::string& name) {
        return pair.changed_weights().at(name).size();
      });
      why.joints = needed(std::move(joints), [&](const auto& fewer) {
        VersionPair::Parts tried = parts;
        tried.weights = fewer;
        return still(tried);
      });
      for (const std::string& name : why.joints)
        why.vertices.insert(why.vertices.end(), pair.changed_weights().at(name).begin(),
                            pair.changed_weights().at(name).end());
      std::ranges::sort(why.vertices);
    }
    out.findings.push_back(std::move(why));
  }
  std::ranges::stable_sort(out.findings, std::greater<>(),
                           [](const WhyFinding& each) { return badness(each.finding); });
  progress.finish();
  return out;
}

std::optional<FirstBad> first_bad(Index count, const std::function<Failures(Index)>& failures) {
  const Failures first = failures(0), last = failures(count - 1);
  const std::vector<std::string> keys = worse_in(first, last);
  if (keys.empty()) return std::nullopt;
  FirstBad out{0, count - 1, 0, {}};
  std::set<Index> unmeasured;
  const auto is_bad = [&](const Failures& each) {
    return std::ranges::any_of(keys, [&](const std::string& key) {
      const double was = badness_in(first, key), is = badness_in(last, key);
      const double from = std::max(was, 1.0);
      return badness_in(each, key) > 0.0 && badness_in(each, key) >= from + 0.5 * (is - from);
    });
  };
  while (out.bad - out.good > 1) {
    // The middle one, or the nearest to it that can be measured.
    const Index middle = out.good + (out.bad - out.good) / 2;
    std::optional<Index> chosen;
    for (Index off = 0; !chosen && off < out.bad - out.good; ++off)
      for (const std::ptrdiff_t side : {-1, 1}) {
        const auto at =
            static_cast<std::ptrdiff_t>(middle) + side * static_cast<std::ptrdiff_t>(off);
        if (at <= static_cast<std::ptrdiff_t>(out.good) ||
            at >= static_cast<std::ptrdiff_t>(out.bad))
          continue;
        if (!unmeasured.contains(static_cast<Index>(at))) chosen = static_cast<Index>(at);
      }
    if (!chosen) break;
    try {
      const bool bad = is_bad(failures(*chosen));
      ++out.steps;
      (bad ? out.bad : out.good) = *chosen;
    } catch (const skin::CharacterError& error) {
      unmeasured.insert(*chosen);
      out.skipped.emplace_back(error.what());
    } catch (const solver::RigError& error) {
      unmeasured.insert(*chosen);
      out.skipped.emplace_back(error.what());
    }
  }
  return out;
}

}  // namespace backbend::validate
