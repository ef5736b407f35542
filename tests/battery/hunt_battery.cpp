// Whether `hunt` finds faults that a rig or its weights show in few compound poses: one fault in
// each case, in a known share of the box of a human's envelope, and a uniform random search of the
// same number of poses beside it.
//
//   hunt_battery [options]
//
// --cases N        of each kind: corner flip, ridge, bump, weights [15]
// --seed S         even seeds are for setting the search, odd ones for judging it [1]
// --evaluations N  of both searches [5000]
// --kind K         only `flip`, `ridge`, `bump` or `weights`
// --width W        half width of ridges and bumps, of an axis [0.05 to 0.15, drawn]
// --verbose        a line for every case
//
// Exit code 0 where hunt finds 90 of 100 and the random search at most half as many, else 1.
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <glm/trigonometric.hpp>
#include <map>

#include "tests/battery/body_variants.h"
#include "tests/battery/pose_faults.h"
#include "tests/battery/weight_faults.h"
#include "tests/source_folder.h"
#include "validate/hunt/hunt.h"
#include "validate/judge/judge.h"

namespace backbend::battery {
namespace {

using namespace validate;
using Index = std::size_t;

struct Options {
  Index cases = 15, evaluations = 5000;
  std::uint64_t seed = 1;
  std::string kind;
  double width = 0.0;
  bool verbose = false;
};

/// What both searches made of one case.
struct Result {
  std::string kind, what;
  double share = 0.0;  // as measured
  bool hunted = false, chanced = false, clean = true, false_find = false;
  Index evaluations = 0;
};

/// A body, its rig `even`, and how its poses are judged.
struct Subject {
  Subject(skin::Character character, const skin::Anatomy& anatomy)
      : stage(std::move(character), anatomy),
        body(stage.character(), stage.anatomy(), stage.driver()),
        envelope(*find_envelope("human")),
        box(find_box("envelope", envelope)),
        plan(read_rig("even")) {}

  HuntScene scene(std::function<std::unique_ptr<solver::SpineSystem>()> build) const {
    return {stage, body, envelope, limits, plan, solver::Mapping::chest, "human", std::move(build)};
  }

  Stage stage;
  BodyMetrics body;
  Envelope envelope;
  LimitSet limits;
  ControlBox box;
  RigPlan plan;
};

/// The measured value over its limit of one check, pose by pose.
class Measure {
 public:
  Measure(const Subject& on, std::string code, std::unique_ptr<solver::SpineSystem> system)
      : on_(on),
        check_(*find_check(code)),
        metric_(metric_of(code) == nullptr ? MetricId::chain_kink : metric_of(code)->id),
        rig_(plan_rig(on.stage, on.body, on.plan, solver::Mapping::chest, {}, on.envelope)) {
    rig_.system = std::move(system);
    at_rest_ = rig_at_rest(*rig_.system);
  }

  double operator()(const std::vector<double>& at) const {
    PoseRecord pose;
    pose.body = on_.box.pose_at(at);
    pose.control = controls_at(*rig_.system, pose.body, solver::Mapping::chest);
    if (check_.subject == Subject_mesh)
      measure_pose(
          on_.body, at_rest_, on_.stage.pose(*rig_.system, pose.control), pose,
          metric_ == MetricId::self_intersection ? Crossing::measured : Crossing::left_out);
    else
      measure_chain_pose(at_rest_, pose);
    if (metric_ == MetricId::mirror) measure_pose_behaviour(on_.stage, rig_, pose);
    if (check_.subject == Subject_mesh && pose.at(MetricId::feasibility).value >= 1.0) return 0.0;
    const double limit = limit_at(check_.code, on_.limits.of(check_.code).value,
                                  compound_load(on_.envelope, pose.body));
    const double value = excess(check_, pose.at(metric_).value, limit);
    return std::isfinite(value) ? value : 0.0;
  }

 private:
  static constexpr validate::Subject Subject_mesh = validate::Subject::mesh;
  const Subject& on_;
  const Check& check_;
  MetricId metric_;
  RigRecord rig_;
  RigAtRest at_rest_{};
};

std::vector<double> random_point(Draw& draw, const std::vector<double>& low,
                                 const std::vector<double>& high) {
  std::vector<double> at;
  for (Index a = 0; a < low.size(); ++a) at.push_back(draw.uniform(low[a], high[a]));
  return at;
}

/// How many of `count` seeded points between `low` and `high` fail, and the first of all if any.
Index count_failing(Index count, std::uint64_t seed, const std::vector<double>& low,
                    const std::vector<double>& high,
                    const std::function<bool(const std::vector<double>&)>& fails) {
  std::atomic<Index> failing{0};
  oneapi::tbb::parallel_for(Index{0}, count, [&](Index i) {
    Draw draw(seed, 1000 + i);
    if (fails(random_point(draw, low, high))) ++failing;
  });
  return failing;
}

const std::vector<double> kZero(3, 0.0), kOne(3, 1.0);

Result judge_pose_fault(const Subject& on, PoseFault fault, const Options& options,
                        std::uint64_t seed) {
  Result out;
  out.kind = fault.kind;
  out.what = fault.code;
  const auto sound = [&] { return on.stage.build(on.plan.spec); };
  std::function<bool(const std::vector<double>&)> fails;
  std::shared_ptr<Measure> measure;
  if (fault.code == "BB001") {
    out.what += " " + number_text(glm::degrees(fault.amount), 0) + " deg, joint " +
                std::to_string(fault.joint);
    fails = [&](const std::vector<double>& at) { return fault.strength(at) > 0.0; };
  } else {
    // As much of the fault as makes it pass the limit where it is meant to.
    double low = 0.0, high = glm::radians(60.0);
    for (int i = 0; i < 40; ++i) {
      fault.amount = 0.5 * (low + high);
      const Measure at_edge(on, fault.code, with_fault(sound(), on.box, fault));
      (at_edge(fault.edge) < 1.0 ? low : high) = fault.amount;
    }
    measure = std::make_shared<Measure>(on, fault.code, with_fault(sound(), on.box, fault));
    fails = [&](const std::vector<double>& at) { return (*measure)(at) > 1.0; };
  }
  constexpr Index kSamples = 4'000;
  double part = 1.0;
  for (Index a = 0; a < fault.low.size(); ++a) part *= fault.high[a] - fault.low[a];
  out.share = part *
              static_cast<double>(count_failing(kSamples, seed, fault.low, fault.high, fails)) /
              kSamples;
  Progress silent(Progress::Style::none);
  const HuntSettings settings{on.box, "", options.evaluations, seed};
  const Hunt hunt =
      hunt_poses(on.scene([&] { return with_fault(sound(), on.box, fault); }), settings, silent);
  out.evaluations = hunt.evaluations;
  for (const HuntFind& find : hunt.finds) {
    if (find.finding.code == fault.code) out.hunted = true;
    // What measuring the pose once more, with a rig of its own, does not show.
    const std::vector<double> at = on.box.point_of(find.pose), from = on.box.point_of(find.from);
    if (find.finding.code == "BB001") {
      out.false_find |= fault.strength(at) == fault.strength(from);
    } else if (find.finding.code != "BB002" && find.finding.verdict == Verdict::fail) {
      const Measure again(on, find.finding.code, with_fault(sound(), on.box, fault));
      out.false_find |= again(at) < 0.999;  // a point is not its pose to the last digit
    }
  }
  out.chanced = count_failing(hunt.evaluations, seed + 7919, kZero, kOne, fails) > 0;
  return out;
}

/// Weights that fail only in compound poses: the fault is planted, and the limit set so that it is
/// passed in the wanted share of the box.
std::optional<Result> judge_weight_fault(const skin::Character& human,
                                         const skin::AnatomyHints& hints, double share,
                                         const Options& options, std::uint64_t seed) {
  Draw draw(seed, 3);
  const char* kinds[] = {"vertebra smeared on one side", "half torso one up",
                         "clavicle on a vertebra", "vertebra smeared", "bleed to thigh"};
  const std::string kind = kinds[draw.index(5)];
  skin::Character body = human;
  const skin::Anatomy anatomy = skin::find_anatomy(body, hints);
  const WeightFault fault = plant(body, anatomy, kind, kind == "bleed to thigh" ? 20 : 50, draw);
  if (fault.joints.empty()) return std::nullopt;
  Subject clean(human, anatomy), on(std::move(body), anatomy);
  Result out;
  out.kind = "weights";
  // The check that the fault changes most, in a few hundred poses.
  std::string code;
  double most = 1.05;
  for (const char* each : {"BB011", "BB012", "BB030", "BB031", "BB033", "BB036"}) {
    const Measure before(clean, each, clean.stage.build(clean.plan.spec)),
        after(on, each, on.stage.build(on.plan.spec));
    std::vector<double> worst(200), sound(200);
    oneapi::tbb::parallel_for(Index{0}, worst.size(), [&](Index i) {
      Draw at(seed, 5000 + i);
      const std::vector<double> point = random_point(at, kZero, kOne);
      worst[i] = after(point);
      sound[i] = before(point);
    });
    const double ratio = *std::ranges::max_element(worst) / *std::ranges::max_element(sound);
    if (ratio > most) {
      most = ratio;
      code = each;
    }
  }
  if (code.empty()) return std::nullopt;
  out.what = code + " " + kind;
  const Measure measure(on, code, on.stage.build(on.plan.spec));
  // The tail of the values: where the worst of many poses lie, sampled again more densely.
  constexpr Index kSamples = 6'000;
  const auto sample = [&](std::uint64_t stream, const std::vector<double>& low,
                          const std::vector<double>& high) {
    std::vector<std::pair<double, std::vector<double>>> values(kSamples);
    oneapi::tbb::parallel_for(Index{0}, kSamples, [&](Index i) {
      Draw at(seed + stream, 20'000 + i);
      values[i].second = random_point(at, low, high);
      values[i].first = measure(values[i].second);
    });
    std::ranges::sort(values, std::greater<>());
    return values;
  };
  std::vector<double> low = kZero, high = kOne;
  double part = 1.0;
  std::vector<std::pair<double, std::vector<double>>> values;
  for (int round = 0; round < 3; ++round) {
    values = sample(static_cast<std::uint64_t>(round), low, high);
    if (share / part * kSamples > 40) break;
    // What holds the worst hundredth, and some room around it.
    std::vector<double> from(3, 1.0), to(3, 0.0);
    for (Index i = 0; i < kSamples / 100; ++i)
      for (Index a = 0; a < 3; ++a) {
        from[a] = std::min(from[a], values[i].second[a]);
        to[a] = std::max(to[a], values[i].second[a]);
      }
    part = 1.0;
    for (Index a = 0; a < 3; ++a) {
      const double room = 0.1 * (to[a] - from[a]) + 0.01;
      low[a] = std::max(low[a], from[a] - room);
      high[a] = std::min(high[a], to[a] + room);
      part *= high[a] - low[a];
    }
  }
  const auto rank = static_cast<Index>(share / part * kSamples);
  const double level = values[std::clamp<Index>(rank, 1, kSamples - 1)].first;
  out.share = part * static_cast<double>(std::clamp<Index>(rank, 1, kSamples - 1)) / kSamples;
  const Check& check = *find_check(code);
  const double old = on.limits.of(code).value;
  Limit limit;
  // limit_at() of BB030 counts the loss, and excess() divides by the value.
  limit.value = check.sense == Sense::at_most ? old * level : old / level;
  limit.layer = LimitLayer::show;
  limit.owner = limit.reason = "battery";
  on.limits.set(code, limit);
  clean.limits.set(code, limit);
  Progress silent(Progress::Style::none);
  const HuntSettings settings{on.box, "", options.evaluations, seed};
  const Hunt hunt = hunt_poses(on.scene({}), settings, silent);
  out.evaluations = hunt.evaluations;
  for (const HuntFind& find : hunt.finds) out.hunted |= find.finding.code == code;
  const Measure again(on, code, on.stage.build(on.plan.spec));
  const auto fails = [&](const std::vector<double>& at) { return again(at) > 1.0; };
  // The share under the limit that was set, told by as many poses as the random search has.
  const Index met = count_failing(hunt.evaluations, seed + 7919, kZero, kOne, fails);
  out.chanced = met > 0;
  return out;
}

void print_table(const std::vector<Result>& results) {
  struct Row {
    Index cases = 0, hunted = 0, chanced = 0;
  };
  std::map<std::string, Row> by_kind, by_share;
  const auto band = [](double share) {
    return share < 2e-5   ? "1 below 0.002 %"
           : share < 1e-4 ? "2 0.002 to 0.01 %"
           : share < 4e-4 ? "3 0.01 to 0.04 %"
                          : "4 above 0.04 %";
  };
  for (const Result& each : results)
    for (Row* row : {&by_kind[each.kind], &by_share[band(each.share)]}) {
      ++row->cases;
      row->hunted += each.hunted;
      row->chanced += each.chanced;
    }
  for (const auto* table : {&by_kind, &by_share}) {
    std::printf("| %-20s | cases | hunt | random |\n|---|---|---|---|\n",
                table == &by_kind ? "kind" : "share of the box");
    for (const auto& [name, row] : *table)
      std::printf("| %-20s | %zu | %zu | %zu |\n",
                  table == &by_share ? name.c_str() + 2 : name.c_str(), row.cases, row.hunted,
                  row.chanced);
  }
}

int run(const Options& options) {
  skin::Character human =
      welded(load_character(source_folder() / "scenes" / "characters" / "human.toml"));
  decimate(human, 2000);
  const skin::AnatomyHints hints;
  const Subject on(human, skin::find_anatomy(human, hints));
  const Index joints = on.stage.build(on.plan.spec)->rest().joint_count();
  std::vector<Result> results;
  const auto add = [&](const Result& result) {
    results.push_back(result);
    if (options.verbose || !result.hunted || result.false_find)
      std::printf("%-12s %-36s share %.5f %%  hunt %s, random %s%s\n", result.kind.c_str(),
                  result.what.c_str(), 100.0 * result.share, result.hunted ? "found" : "MISSED",
                  result.chanced ? "found" : "missed", result.false_find ? ", FALSE FIND" : "");
    std::fflush(stdout);
  };
  for (const std::string kind : {"flip", "ridge", "bump", "weights"}) {
    if (!options.kind.empty() && options.kind != kind) continue;
    for (Index n = 0; n < options.cases; ++n) {
      const std::uint64_t seed = options.seed * 100'003 + n * 17;
      Draw draw(seed, kind[0]);
      // Evenly over the decades from 0.001 to 0.1 %.
      const double share = std::pow(
          10.0, -5.0 + 2.0 * (static_cast<double>(n) + 0.5) / static_cast<double>(options.cases));
      const double width = options.width > 0.0 ? options.width : draw.uniform(0.05, 0.15);
      if (kind == "weights") {
        std::optional<Result> result;
        for (Index again = 0; !result && again < 10; ++again)
          result = judge_weight_fault(human, hints, share, options, seed + 1 + again * 31);
        if (result) add(*result);
      } else {
        add(judge_pose_fault(on,
                             kind == "flip"    ? draw_corner_flip(3, share, joints, draw)
                             : kind == "ridge" ? draw_ridge(share, width, joints, draw)
                                               : draw_bump(share, width, joints, draw),
                             options, seed));
      }
    }
  }
  print_table(results);
  const auto count = [&](auto member) {
    return static_cast<Index>(
        std::ranges::count_if(results, [&](const Result& r) { return r.*member; }));
  };
  const Index hunted = count(&Result::hunted), chanced = count(&Result::chanced),
              wrong = count(&Result::false_find);
  std::printf("hunt %zu of %zu, random %zu, false finds %zu\n", hunted, results.size(), chanced,
              wrong);
  return 10 * hunted >= 9 * results.size() && 2 * chanced <= hunted && wrong == 0 ? 0 : 1;
}

}  // namespace
}  // namespace backbend::battery

int main(int argc, char** argv) {
  backbend::battery::Options options;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--verbose") {
      options.verbose = true;
      continue;
    }
    if (i + 1 == argc) return 2;
    const char* value = argv[++i];
    if (word == "--cases")
      options.cases = std::strtoull(value, nullptr, 10);
    else if (word == "--seed")
      options.seed = std::strtoull(value, nullptr, 10);
    else if (word == "--evaluations")
      options.evaluations = std::strtoull(value, nullptr, 10);
    else if (word == "--kind")
      options.kind = value;
    else if (word == "--width")
      options.width = std::strtod(value, nullptr);
    else
      return 2;
  }
  return backbend::battery::run(options);
}
