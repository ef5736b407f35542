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
// A finding that a mixture has to this share of the limit is known: what the others add may be a
// hair that a split vertex makes.
constexpr double kNearLimit = 0.8;

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

/// What a version fails, and of the findings that are asked for what it nearly fails and what is
/// booked to the skeleton or the pose.
struct Judged {
  Failures failures, near, advisory;
};

/// `advisory`: whoever it is booked to.
double badness_in(const Judged& judged, const std::string& key, bool advisory = false) {
  return std::max({badness_in(judged.failures, key), badness_in(judged.near, key),
                   advisory ? badness_in(judged.advisory, key) : 0.0});
}

/// A limit on the good side by kNearLimit, of what is lost where a share is to be kept; its inverse
/// where `back`.
double near_limit(const Check& check, double limit, bool back) {
  const double factor = back ? 1.0 / kNearLimit : kNearLimit;
  return check.sense == Sense::at_least ? 1.0 - (1.0 - limit) * factor : limit * factor;
}

/// What passes by less than kNearLimit. `weights`: nullptr where the input is not asked.
std::vector<Finding> near_findings(const RigRecord& rig, const JudgeContext& context,
                                   const BodyMetrics& body, const InputReading* weights) {
  LimitSet nearer = context.limits;
  for (const Check& check : all_checks())
    if (metric_of(check.code) || (check.subject == Subject::input && check.decides))
      nearer.set(check.code,
                 {near_limit(check, nearer.of(check.code).value, false), LimitLayer::character,
                  "why", "why", "so near that it is known in a mixture"});
  const JudgeContext near{context.stage, nearer, context.envelope, context.character};
  std::vector<Finding> findings = judge_rig(rig, near);
  std::erase_if(findings, [](const Finding& each) { return metric_of(each.code) == nullptr; });
  if (weights != nullptr)
    for (Finding& finding : judge_input(rig, near, *weights, body, true).findings)
      findings.push_back(std::move(finding));
  for (Finding& each : findings) each.limit = near_limit(*find_check(each.code), each.limit, true);
  return findings;
}

/// `only`: the key of the one finding that is asked for; then only its sweep is measured. `asked`:
/// the findings of which is told what is not a failure, too. Throws as failures_of() does.
Judged measure(const Version& version, const WhySettings& settings, const std::string& only,
               const std::set<std::string>& asked) {
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
  std::optional<InputReading> weights;
  if (only.empty() || sweep.empty()) {
    weights = read_input(stage);
    for (Finding& finding : judge_input(rig, context, *weights, body, true).findings)
      findings.push_back(std::move(finding));
  }
  Judged out;
  std::set<std::string> wanted = asked;
  for (const Finding& finding : findings)
    if (finding.inside_envelope) wanted.erase(key_of(finding));
  if (!wanted.empty()) {
    std::vector<Finding> near = near_findings(rig, context, body, weights ? &*weights : nullptr);
    std::erase_if(near, [&](const Finding& each) { return !wanted.contains(key_of(each)); });
    book_owners(stage, body, rig, true, near);
    for (Finding& finding : near) {
      if (!finding.inside_envelope || !std::isfinite(finding.value)) continue;
      Failures& into = finding.verdict == Verdict::fail ? out.near : out.advisory;
      add_failure(std::move(finding), into);
    }
  }
  const PlaceNames places(stage.character(), stage.anatomy(), &body);
  for (Finding& finding : findings) {
    if (!find_check(finding.code) || !std::isfinite(finding.value)) continue;
    if (finding.verdict != Verdict::fail) {
      if (finding.inside_envelope && asked.contains(key_of(finding)))
        add_failure(std::move(finding), out.advisory);
      continue;
    }
    if (is_external(version.rig.spec) && finding.owner == Owner::solver) finding.owner = Owner::rig;
    places.name({}, finding);
    add_failure(std::move(finding), out.failures);
  }
  return out;
}

}  // namespace

Failures failures_of(const Version& version, const WhySettings& settings) {
  return measure(version, settings, {}, {}).failures;
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

  /// Of which findings mixtures tell what is not a failure, too, from now on.
  void ask_for(std::set<std::string> keys) { asked_ = std::move(keys); }

  /// Nullptr: the mixture cannot be measured.
  const Judged* of(IngredientSet set) {
    const auto known = measured_.find(set);
    if (known != measured_.end()) return known->second ? &*known->second : nullptr;
    poll_interrupt();
    std::optional<Judged> found;
    try {
      found = measure(pair_.mixed(set), settings_, {}, asked_);
      ++out_.measured;
    } catch (const skin::CharacterError& error) {
      note(set, error.what());
    } catch (const solver::RigError& error) {
      note(set, error.what());
    }
    progress_.step();
    auto& kept = measured_[set] = std::move(found);
    return kept ? &*kept : nullptr;
  }

  void take(IngredientSet set, Judged found) { measured_[set] = std::move(found); }

  /// How bad one finding is in a mixture of parts; nothing where that cannot be measured.
  std::optional<double> bad_in_parts(IngredientSet set, const VersionPair::Parts& parts,
                                     const std::string& key, bool advisory) {
    // Findings of one sweep share its measurement.
    std::string name = std::to_string(set) + "|" + key.substr(std::min<Index>(5, key.size()));
    for (const auto* names : {&parts.weights, &parts.options})
      if (*names)
        for (const std::string& each : **names) name += "|" + each;
    const auto bad = [&](const std::optional<Judged>& judged) {
      return judged ? std::optional(badness_in(*judged, key, advisory)) : std::nullopt;
    };
    if (const auto known = in_parts_.find(name); known != in_parts_.end())
      return bad(known->second);
    poll_interrupt();
    std::optional<Judged> found;
    try {
      found = measure(pair_.mixed(set, parts), settings_, key, asked_);
      ++out_.measured;
    } catch (const skin::CharacterError&) {  // then the part is kept
    } catch (const solver::RigError&) {
    }
    return bad(in_parts_[name] = std::move(found));
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
  std::set<std::string> asked_;
  std::map<IngredientSet, std::optional<Judged>> measured_;
  std::map<std::string, std::optional<Judged>> in_parts_;
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
  const Judged changed = measure(pair.after(), settings, {}, {});
  progress.step();
  std::set<std::string> keys;
  for (const auto& [key, finding] : changed.failures) keys.insert(key);
  mixer.take(0, measure(pair.before(), settings, {}, keys));
  mixer.take(out.changed, changed);
  mixer.ask_for(std::move(keys));
  progress.step();
  out.measured = 2;
  const Failures before = mixer.of(0)->failures, &after = changed.failures;
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
    if (const auto found = before.find(key); found != before.end()) why.was = found->second.value;
    const auto makes = [&](double bad, bool advisory) {
      // Half of what it got worse by.
      const double from = std::max(badness_in(*mixer.of(0), key, advisory), kNearLimit);
      return bad > 0.0 && bad >= from + 0.5 * (badness(why.finding) - from);
    };
    const auto smallest = [&](bool advisory) -> IngredientSet {
      for (const IngredientSet set : subsets(pair.changed())) {
        const Judged* with = mixer.of(set);
        if (with == nullptr || !makes(badness_in(*with, key, advisory), advisory)) continue;
        const Judged* without = mixer.of(pair.changed() & ~set);
        if (without != nullptr && !makes(badness_in(*without, key, advisory), advisory)) return set;
      }
      return 0;
    };
    // Of fewer ingredients that make the value, the others only change whom it is booked to: a
    // vertex that was split can do that.
    const IngredientSet failing = smallest(false), by_value = smallest(true);
    const bool advisory = by_value != 0 && (failing == 0 || (by_value & ~failing) == 0);
    why.ingredients = advisory ? by_value : failing;
    if (const Judged* without = mixer.of(pair.changed() & ~why.ingredients);
        why.ingredients != 0 && without != nullptr)
      if (const auto found = without->failures.find(key); found != without->failures.end())
        why.without = found->second.value;
    VersionPair::Parts parts;
    const auto still = [&](const VersionPair::Parts& tried) {
      const auto bad = mixer.bad_in_parts(why.ingredients, tried, key, advisory);
      return bad && makes(*bad, advisory);
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
