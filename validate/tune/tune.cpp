#include "validate/tune/tune.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "validate/judge/judge.h"
#include "validate/judge/owner.h"
#include "validate/judge/searched_character.h"
#include "validate/sweeps/external_spec.h"
#include "validate/sweeps/sweep_named.h"
#include "validate/tasks/seconds_of.h"
#include "validate/tune/choice_sheet.h"
#include "validate/tune/trade_search.h"

namespace backbend::validate {
namespace {

using Index = std::size_t;

constexpr double kSame = 1e-9;        // of a gauge: an option that changes less changes nothing
constexpr double kLeastGain = 0.005;  // of the envelope's way: less is not worth another choice
constexpr double kNoChange = 5e-3;    // %: prints as 0

/// Levels of change, % of the spine, at which choices are offered; without bound one more.
std::vector<double> levels_of(double change) {
  return {kNoChange, change / 5.0, change, 4.0 * change};
}

class Tuner {
 public:
  Tuner(const TuneRequest& request, const SearchedCharacter& searched, Progress& progress)
      : request_(request),
        stage_(*searched.stage),
        envelope_(searched.envelope.whole_sweep
                      ? reach_of(searched.envelope, standard_sweeps(searched.envelope))
                      : searched.envelope),
        body_(stage_.character(), stage_.anatomy(), stage_.driver()),
        space_(request.rig.spec, stage_.build(request.rig.spec)->options(),
               solver::option_ranges(request.rig.spec, stage_.rest_chain()), request.vary),
        gauge_(stage_, body_, envelope_, limits_, request.mapping, request.rig.spec),
        progress_(progress) {
    out_.facts = searched.facts;
    out_.rig = request.rig.name;
    out_.mapping = mapping_name(request.mapping);
    out_.envelope = envelope_;
    out_.directions = gauge_.directions();
    out_.poses = gauge_.poses();
    out_.change = request.change;
  }

  TuneResult run() {
    progress_.start("rigs", request_.evaluations);
    std::optional<RigGauge> given;
    const double took_s = seconds_of([&] { given = gauge(request_.rig.spec); });
    out_.given.gauge = *given;
    if (request_.plan_only) {
      out_.minutes = took_s * static_cast<double>(request_.evaluations) / 60.0;
      progress_.finish();
      measure_as_check(out_.given, request_.rig.spec);
      return finished();
    }
    if (request_.vary.empty()) drop_idle();
    const std::vector<TradePoint> front = search();
    progress_.finish();
    measure_as_check(out_.given, request_.rig.spec);
    for (const TradePoint& point : front) {
      const solver::SystemSpec spec = space_.at(point.at);
      if (spec.options == request_.rig.spec.options) continue;
      TuneChoice choice;
      choice.gauge = *gauge(spec);
      if (choice.gauge.headroom < out_.given.gauge.headroom + kLeastGain) continue;
      measure_as_check(choice, spec);
      out_.choices.push_back(std::move(choice));
    }
    for (Index i = 0; i < out_.choices.size(); ++i)
      if (out_.choices[i].gauge.change <= request_.change && out_.choices[i].made.empty())
        out_.chosen = i;
    if (request_.picture && !out_.choices.empty()) take_sheet();
    return finished();
  }

 private:
  /// Nullopt: the system refuses these options together. Each rig is measured once.
  std::optional<RigGauge> gauge(const solver::SystemSpec& spec) {
    const std::string key = rig_text(spec);
    if (const auto known = known_.find(key); known != known_.end()) return known->second;
    poll_interrupt();
    std::optional<RigGauge> value;
    try {
      value = gauge_.of(spec);
      ++out_.evaluations;
    } catch (const solver::RigError&) {
      if (spec.options == request_.rig.spec.options) throw;
      ++out_.impossible;
    }
    progress_.step();
    return known_.emplace(key, std::move(value)).first->second;
  }

  /// Options that change neither headroom nor shape at any of their ends, by themselves.
  void drop_idle() {
    const RigGauge& given = out_.given.gauge;
    const auto changes = [&](const std::vector<double>& at) {
      const auto value = gauge(space_.at(at));
      if (!value) return true;  // it matters to others
      return value->change > kSame || std::abs(value->headroom - given.headroom) > kSame;
    };
    for (Index axis = space_.axes().size(); axis-- > 0;) {
      const OptionAxis& each = space_.axes()[axis];
      const Index steps = each.kind == OptionAxis::Kind::choice ? each.values() : 2;
      bool works = false;
      for (Index i = 0; i < steps && !works; ++i) {
        std::vector<double> at = space_.origin();
        at[axis] = static_cast<double>(i) / static_cast<double>(std::max<Index>(1, steps - 1));
        works = changes(at);
      }
      if (works) continue;
      out_.idle.push_back(each.name());
      space_.drop(axis);
    }
    std::ranges::reverse(out_.idle);
    if (space_.axes().empty())
      throw solver::RigError("rig '" + request_.rig.name +
                             "': none of its options changes its headroom or its shape here");
  }

  std::vector<TradePoint> search() {
    TradeSettings settings;
    settings.origin = space_.origin();
    for (const OptionAxis& axis : space_.axes()) settings.values.push_back(axis.values());
    settings.evaluations =
        request_.evaluations - std::min(request_.evaluations - 1, known_.size() - 1);
    settings.levels = levels_of(request_.change);
    settings.key = [&](std::span<const double> at) { return rig_text(space_.at(at)); };
    settings.look = [&](std::span<const double> at) -> std::optional<TradeValue> {
      const auto value = gauge(space_.at(at));
      if (!value) return std::nullopt;
      return TradeValue{value->headroom, value->change};
    };
    return front_of(search_trade(settings), levels_of(request_.change), kLeastGain);
  }

  /// Fills in what `check` says of a rig: the standard sweeps and the corners.
  void measure_as_check(TuneChoice& choice, const solver::SystemSpec& spec) {
    choice.spec = spec;
    const auto options = stage_.build(spec)->options();
    const auto given = stage_.build(request_.rig.spec)->options();
    for (const auto& [key, value] : options)
      if (given.at(key) != value)
        choice.options.emplace_back(key, rig_text({"", {{key, value}}}).substr(key.size() + 2));
    const std::vector<Sweep> sweeps = bundled_sweeps(envelope_);
    const RigPlan plan{request_.rig.name, spec, Role::proposed, std::nullopt};
    Index poses = 0;
    for (const Sweep& sweep : sweeps) poses += sweep.pose_count();
    progress_.start("poses", poses);
    const RigRecord rig =
        measure_rig(stage_, body_, plan, request_.mapping, sweeps, envelope_, progress_);
    progress_.finish();
    const JudgeContext context{stage_, limits_, envelope_, request_.character.string()};
    std::vector<Finding> findings = judge_rig(rig, context);
    book_owners(stage_, body_, rig, true, findings);
    choice.channels = headroom_of(rig, context, findings);
    choice.corners = corners_of(rig, context, findings);
    std::set<std::string> failing;
    for (const Finding& finding : findings) {
      if (finding.verdict != Verdict::fail) continue;
      ++choice.failures;
      failing.insert(finding.code + " " + finding.sweep);
    }
    if (&choice == &out_.given) {
      failing_ = std::move(failing);
      return;
    }
    std::ranges::set_difference(failing, failing_, std::back_inserter(choice.made));
  }

  void take_sheet() {
    std::vector<SheetRig> rigs{{"given", request_.rig.spec}};
    for (Index i = 0; i < out_.choices.size(); ++i)
      rigs.push_back({"choice " + std::to_string(i + 1), out_.choices[i].spec});
    std::vector<Direction> poses{out_.directions[out_.given.gauge.worst]};
    if (out_.given.gauge.worst != 0) poses.insert(poses.begin(), out_.directions.front());
    out_.sheet = choice_sheet(stage_, rigs, poses, request_.mapping, progress_);
  }

  TuneResult finished() {
    out_.varied = space_.axes();
    return std::move(out_);
  }

  const TuneRequest& request_;
  const Stage& stage_;
  const Envelope envelope_;
  const LimitSet limits_;
  const BodyMetrics body_;
  OptionSpace space_;
  const HeadroomGauge gauge_;
  Progress& progress_;
  TuneResult out_;
  std::map<std::string, std::optional<RigGauge>> known_;
  std::set<std::string> failing_;  // of the given rig
};

}  // namespace

TuneResult tune(const TuneRequest& request, Progress& progress) {
  if (is_external(request.rig.spec))
    throw solver::RigError("rig '" + request.rig.name +
                           "' is a rig of your own: tune varies the options of our systems "
                           "(backbend list rigs)");
  const SearchedCharacter searched =
      load_searched(request.character, request.hints, request.chain, request.rig, request.envelope);
  Tuner tuner(request, searched, progress);  // refuses what cannot be varied
  if (request.on_character) request.on_character(searched.facts);
  return tuner.run();
}

}  // namespace backbend::validate
