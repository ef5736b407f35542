// Spine solves per second on one core: random poses of the three controls, ten bones.
#include <benchmark/benchmark.h>

#include <random>

#include "solver/rotation.h"
#include "solver/spine_system.h"

namespace backbend::solver {
namespace {

constexpr std::size_t kPoses = 1024;

struct Workload {
  std::unique_ptr<SpineSystem> system;
  std::vector<std::vector<double>> control;
};

Workload make(const std::string& name, std::map<std::string, OptionValue> options) {
  Workload work;
  work.system = build_system({name, std::move(options)},
                             {.joint = {{0, 0, 0}, {0, 2, 0.5}, {0, 4.1, 0.2}, {0, 6, -0.6}}});
  std::mt19937 rng(1);
  std::uniform_real_distribution<double> angle(radians(-60.0), radians(60.0));
  for (std::size_t i = 0; i < kPoses; ++i) {
    std::vector<double> control;
    for (const Channel& c : work.system->channels()) {
      control.push_back(c.kind == Channel::Kind::rotation ? angle(rng) : c.rest);
    }
    work.control.push_back(control);
  }
  return work;
}

void solve(benchmark::State& state, const std::string& name,
           const std::map<std::string, OptionValue>& options, Detail detail) {
  const Workload work = make(name, options);
  SpinePose pose;
  for (const auto& control : work.control) {  // fast and wrong is wrong
    const SpinePose expected = work.system->solve(control);
    work.system->solve_into(control, detail, pose);
    if (pose.position != expected.position || pose.turn != expected.turn) {
      return state.SkipWithError("solve_into() and solve() differ");
    }
  }
  std::size_t i = 0;
  for (auto _ : state) {
    work.system->solve_into(work.control[i++ % kPoses], detail, pose);
    benchmark::DoNotOptimize(pose.position.data());
    benchmark::ClobberMemory();
  }
  state.SetItemsProcessed(state.iterations());  // poses per second
}

using Options = std::map<std::string, OptionValue>;
BENCHMARK_CAPTURE(solve, three_bone, "three_bone", Options{}, Detail::joints);
BENCHMARK_CAPTURE(solve, curve, "curve", Options{}, Detail::joints);
BENCHMARK_CAPTURE(solve, curve_with_measures, "curve", Options{}, Detail::all);
BENCHMARK_CAPTURE(solve, curve_full_roll, "curve", (Options{{"roll", "full"}}), Detail::joints);
BENCHMARK_CAPTURE(solve, curve_interpolate_on_curve, "curve",
                  (Options{{"basis", "interpolate"}, {"follow", "on_curve"}}), Detail::joints);
BENCHMARK_CAPTURE(solve, isner, "isner", Options{}, Detail::joints);
BENCHMARK_CAPTURE(solve, isner_ten, "isner", (Options{{"vertebrae", 10.0}}), Detail::joints);
BENCHMARK_CAPTURE(solve, even, "even", Options{}, Detail::joints);

}  // namespace
}  // namespace backbend::solver

BENCHMARK_MAIN();
