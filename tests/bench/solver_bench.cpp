// Spine solves per second on one core: random poses of each system, one by one and as crowds.
// Items are poses; the rate is by processor time.
#include <benchmark/benchmark.h>

#include <random>

#include "solver/math/rotation.h"
#include "solver/rig/crowd.h"
#include "solver/rig/spine_system.h"

namespace backbend::solver {
namespace {

using Options = std::map<std::string, OptionValue>;

struct Case {
  const char* title;
  const char* system;
  Options options;
};

// Ten bones where a system lets one choose; otherwise its own defaults.
const Case kCases[] = {
    {"three_bone", "three_bone", {}},
    {"curve", "curve", {}},
    {"curve_full_roll", "curve", {{"roll", "full"}}},
    {"curve_on_curve", "curve", {{"basis", "interpolate"}, {"follow", "on_curve"}}},
    {"isner", "isner", {{"vertebrae", 10.0}}},
    {"even", "even", {}},
    {"even_reach", "even", {{"reach", 1.0}}},
    {"even_limits", "even", {{"limits", "human"}}},
    {"stretchy_bones", "stretchy", {{"bones", 10.0}}},
    {"stretchy_carve", "stretchy", {{"bones", 10.0}, {"form", "carve"}}},
    {"neck", "neck", {}},
    {"snake_100", "snake", {{"joints", 100.0}}},
    {"spline_ik", "spline_ik", {{"bones", 10.0}}},
    {"matrix_blend", "matrix_blend", {{"bones", 10.0}}},
};

std::unique_ptr<SpineSystem> build(const Case& c) {
  return build_system({c.system, c.options},
                      {.joint = {{0, 0, 0}, {0, 2, 0.5}, {0, 4.1, 0.2}, {0, 6, -0.6}}});
}

/// Turns of up to 60 degrees on every channel, all else at rest; the snake slides and slithers.
std::vector<double> random_controls(const SpineSystem& system, std::size_t poses) {
  std::mt19937 rng(1);
  std::vector<double> value;
  for (const Channel& c : system.channels()) {
    for (std::size_t i = 0; i < poses; ++i) {
      const double unit = double(rng()) / 4294967296.0;  // 0..1, the same on every machine
      const bool slides = c.name == "slide" || c.name == "amplitude";
      value.push_back(c.kind == Channel::Kind::rotation ? radians(120.0 * unit - 60.0)
                      : slides                          ? 0.5 * unit
                                                        : c.rest);
    }
  }
  return value;
}

void single(benchmark::State& state, const Case& c, Detail detail) {
  constexpr std::size_t kPoses = 1024;
  const auto system = build(c);
  const std::vector<double> value = random_controls(*system, kPoses);
  std::vector<std::vector<double>> control(kPoses);
  for (std::size_t i = 0; i < kPoses; ++i) {
    for (std::size_t ch = 0; ch < system->channels().size(); ++ch) {
      control[i].push_back(value[ch * kPoses + i]);
    }
  }
  SpinePose pose;
  for (const auto& own : control) {  // fast and wrong is wrong
    const SpinePose expected = system->solve(own);
    system->solve_into(own, detail, pose);
    if (pose.position != expected.position || pose.turn != expected.turn) {
      return state.SkipWithError("solve_into() and solve() differ");
    }
  }
  std::size_t i = 0;
  for (auto _ : state) {
    system->solve_into(control[i++ % kPoses], detail, pose);
    benchmark::DoNotOptimize(pose.position.data());
    benchmark::ClobberMemory();
  }
  state.SetItemsProcessed(state.iterations());
}

void crowd(benchmark::State& state, const Case& c) {
  const auto system = build(c);
  const auto poses = std::size_t(state.range(0));
  const std::vector<double> value = random_controls(*system, poses);
  const CrowdControls control{value, poses};
  CrowdPose pose;
  solve_crowd(*system, control, pose);
  for (std::size_t i = 0; i < poses; i += 7) {
    std::vector<double> own;
    for (std::size_t ch = 0; ch < system->channels().size(); ++ch) own.push_back(control.at(ch, i));
    const SpinePose expected = system->solve(own);
    for (std::size_t j = 0; j < expected.joint_count(); ++j) {
      if (pose.position(j, 1)[i] != expected.position[j].y ||
          pose.turn(j, 0)[i] != expected.turn[j].w) {
        return state.SkipWithError("solve_crowd() and solve() differ");
      }
    }
  }
  for (auto _ : state) {
    solve_crowd(*system, control, pose);
    benchmark::DoNotOptimize(pose.position(0, 0).data());
    benchmark::ClobberMemory();
  }
  state.SetItemsProcessed(state.iterations() * state.range(0));
}

}  // namespace
}  // namespace backbend::solver

int main(int argc, char** argv) {
  using namespace backbend::solver;
  for (const Case& c : kCases) {
    const std::string title = c.title;
    benchmark::RegisterBenchmark(("single/" + title).c_str(), single, c, Detail::joints);
    benchmark::RegisterBenchmark(("measured/" + title).c_str(), single, c, Detail::all);
    auto* many = benchmark::RegisterBenchmark(("crowd/" + title).c_str(), crowd, c);
    for (const int poses : {1, 10, 100, 1000, 10000}) many->Arg(poses);
  }
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
}
